// candidates.outlines: the outlines of a binary image, the quads around them and their straight parts
#include <cstring>

#include "algebra.h"
#include "steps.h"

namespace {

using namespace alvar;

struct Point {
    double x, y;
};

constexpr int kHullPoints = 80;  // longer outlines are thinned before their hull is taken

double cross(const Point& a, const Point& b, const Point& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// On rows of bytes (__restrict, because the compiler must assume that they overlap): 1 where the difference is at least
// `offset`; the sums of three; 1 where they are at least five.
void compare(const std::uint8_t* __restrict a, const std::uint8_t* __restrict b, std::uint8_t offset, int width,
             std::uint8_t* __restrict out) {
    for (int x = 0; x < width; ++x) {
        const std::uint8_t difference = a[x] > b[x] ? a[x] - b[x] : 0;
        out[x] = difference >= offset;
    }
}

void add(const std::uint8_t* a, const std::uint8_t* b, const std::uint8_t* c, int width, std::uint8_t* __restrict out) {
    for (int x = 0; x < width; ++x) out[x] = a[x] + b[x] + c[x];
}

void count(const std::uint8_t* a, const std::uint8_t* b, const std::uint8_t* c, int width, std::int8_t* __restrict out) {
    for (int x = 0; x < width; ++x) {
        const std::uint8_t sum = a[x] + b[x] + c[x];
        out[x] = sum >= 5;
    }
}

// Follows the borders of the dark pixels, each once, as Suzuki and Abe do (1985). Dark are those of which five of the
// nine around them are darker than the mean by at least `offset`.
class Borders {
public:
    Borders(const Image& smooth, const Image& mean, int offset)
        : wide((smooth.width + 2 + 15) / 8 * 8), high(smooth.height + 2) {
        const int width = smooth.width, height = smooth.height;
        marks.resize(static_cast<std::size_t>(wide) * high + 8);
        std::fill_n(marks.begin(), wide, kEmpty);
        std::fill(marks.end() - wide - 8, marks.end(), kEmpty);
        std::vector<std::uint8_t> darker(width + 2), sums(3 * width);  // of a pixel and its neighbours in its row
        for (int y = 0; y <= height; ++y) {
            if (y < height) {
                const std::uint8_t *grey = smooth.greys + y * smooth.stride, *around = mean.greys + y * mean.stride;
                compare(around, grey, offset, width, &darker[1]);
                darker[0] = darker[1], darker[width + 1] = darker[width];
                add(&darker[0], &darker[1], &darker[2], width, &sums[y % 3 * width]);
            }
            if (y == 0) continue;
            const std::uint8_t *above = &sums[std::max(y - 2, 0) % 3 * width], *own = &sums[(y - 1) % 3 * width];
            const std::uint8_t* below = &sums[std::min(y, height - 1) % 3 * width];
            std::int8_t* row = &marks[y * wide];
            row[0] = kEmpty;
            count(above, own, below, width, row + 1);
            std::fill(row + width + 1, row + wide, kEmpty);
        }
        const int steps[8] = {1, 1 - wide, -wide, -wide - 1, -1, wide - 1, wide, wide + 1};
        std::memcpy(step, steps, sizeof step);
    }

    // Calls use(outline, whether it is an outer border) for each.
    template <typename Use>
    void each(Use use) {
        for (int y = 1; y < high - 1; ++y) {
            std::int8_t* row = &marks[y * wide];
            int x = 1;
            while (true) {
                x = end_of_run(row, x, false);
                if (x >= wide) break;
                if (row[x] == kNew) use(follow(row + x, x - 1, y - 1, false), true);
                x = end_of_run(row, x, true);
                if (row[x - 1] > 0) use(follow(row + x - 1, x - 2, y - 1, true), false);
            }
        }
    }

private:
    static constexpr std::int8_t kEmpty = 0, kNew = 1, kSeen = 2, kSeenAtRight = -2;
    int wide, high, step[8];
    std::vector<std::int8_t> marks;
    std::vector<Point> outline;

    // The first place from x on that is filled or, if `filled`, empty: eight pixels at once.
    int end_of_run(const std::int8_t* row, int x, bool filled) const {
        constexpr std::uint64_t kHigh = 0x8080808080808080u, kRest = ~kHigh;
        for (; x < wide; x += 8) {
            std::uint64_t eight;
            std::memcpy(&eight, row + x, 8);
            const std::uint64_t full = ((eight & kRest) + kRest) | eight;  // the highest bit of each that is not 0
            const std::uint64_t ends = (filled ? ~full : full) & kHigh;
            if (ends) return x + first_byte(ends);
        }
        return wide;
    }

    // The number of the lowest byte in memory that is not 0
    static int first_byte(std::uint64_t bytes) {
#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
        return __builtin_clzll(bytes) / 8;
#else
        return __builtin_ctzll(bytes) / 8;
#endif
    }

    const std::vector<Point>& follow(std::int8_t* start, int x, int y, bool hole) {
        static const int dx[8] = {1, 1, 0, -1, -1, -1, 0, 1}, dy[8] = {0, -1, -1, -1, 0, 1, 1, 1};
        outline.clear();
        const int from = hole ? 0 : 4;
        int d = from;
        do d = (d - 1) & 7; while (!start[step[d]] && d != from);
        if (!start[step[d]]) {
            *start = kSeenAtRight;
            outline.push_back({double(x), double(y)});
            return outline;
        }
        const std::int8_t* last = start + step[d];
        for (std::int8_t* at = start;;) {
            bool empty_at_right = false;
            while (true) {
                d = (d + 1) & 7;
                if (at[step[d]]) break;
                empty_at_right |= d == 0;
            }
            if (empty_at_right) *at = kSeenAtRight;
            else if (*at == kNew) *at = kSeen;
            outline.push_back({double(x), double(y)});
            std::int8_t* next = at + step[d];
            if (next == start && at == last) return outline;
            x += dx[d], y += dy[d], at = next, d = (d + 4) & 7;
        }
    }
};

// The last of the numbers `of(i)` from `begin` to `end` that is the largest and above 0, in *most; else `begin`.
template <typename Of>
ALVAR_INLINE int largest(int begin, int end, Of of, float* most) {
    constexpr int kBlock = 16;
    int best = begin, block = -1;
    *most = 0;
    for (int i = begin; i < end; i += kBlock) {
        const int some = std::min(kBlock, end - i);
        float here = 0;
        for (int k = 0; k < some; ++k) here = std::max(here, of(i + k));
        if (here > *most) *most = here, block = i;
    }
    float found = 0;
    for (int i = block; block >= 0 && i < std::min(block + kBlock, end); ++i)
        if (of(i) > found) found = of(i), best = i;
    return best;
}

// Polygons within a tolerance of closed curves, as Douglas and Peucker find them (1973).
class Simplifier {
public:
    const std::vector<Point>& operator()(const std::vector<Point>& curve, double tolerance) {
        const int count = curve.size();
        kept.clear(), polygon.clear();
        xs.resize(2 * count), ys.resize(2 * count);  // twice, so that no part has to go on at the start
        for (int i = 0; i < count; ++i) {
            xs[i] = xs[count + i] = curve[i].x, ys[i] = ys[count + i] = curve[i].y;
        }
        int first = 0, second = 0;
        for (int again = 0; again < 3; ++again) {  // two points that are far apart
            first = second;
            const float x = xs[first], y = ys[first];
            float furthest;
            second = largest(0, count, [&](int i) { return (xs[i] - x) * (xs[i] - x) + (ys[i] - y) * (ys[i] - y); },
                             &furthest);
            if (furthest <= tolerance * tolerance) {
                polygon.push_back(curve[first]);
                return polygon;
            }
        }
        if (first > second) std::swap(first, second);
        kept.push_back(first);
        split(first, second, tolerance * tolerance);
        kept.push_back(second);
        split(second, first + count, tolerance * tolerance);
        for (const int i : kept) polygon.push_back(curve[i % count]);
        straighten(tolerance);
        return polygon;
    }

private:
    std::vector<int> kept;
    std::vector<float> xs, ys;
    std::vector<Point> polygon;

    void split(int begin, int end, double square) {
        const float ax = xs[begin], ay = ys[begin], x = xs[end] - ax, y = ys[end] - ay;
        float furthest;
        const int at = largest(begin + 1, end, [&](int i) { return std::fabs((ys[i] - ay) * x - (xs[i] - ax) * y); },
                               &furthest);
        if (double(furthest) * furthest <= square * (double(x) * x + double(y) * y)) return;
        split(begin, at, square);
        kept.push_back(at);
        split(at, end, square);
    }

    // Leaves out corners that are nearly straight.
    void straighten(double tolerance) {
        for (int i = 0, left = polygon.size(); left-- > 0 && polygon.size() > 3;) {
            const int count = polygon.size();
            const Point &a = polygon[(i + count - 1) % count], &b = polygon[i % count], &c = polygon[(i + 1) % count];
            const double off = cross(a, c, b), x = c.x - a.x, y = c.y - a.y;
            const bool forward = (b.x - a.x) * (c.x - b.x) + (b.y - a.y) * (c.y - b.y) >= 0;
            if (forward && off * off <= 0.5 * tolerance * tolerance * (x * x + y * y))
                polygon.erase(polygon.begin() + i % count);
            else ++i;
        }
    }
};

// The convex hull of an outline: by the first and the last point of each row.
class Hull {
public:
    const std::vector<Point>& operator()(const std::vector<Point>& outline, int stride, int top, int height) {
        first.assign(height, 1e9), last.assign(height, -1e9);
        for (std::size_t i = 0; i < outline.size(); i += stride) {
            const int row = int(outline[i].y) - top;
            first[row] = std::min(first[row], outline[i].x), last[row] = std::max(last[row], outline[i].x);
        }
        hull.clear();
        for (int row = 0; row < height; ++row)  // down on the right
            if (last[row] > -1e9) add({last[row], double(top + row)}, 0);
        const std::size_t turn = hull.size() - 1;
        for (int row = height - 1; row >= 0; --row)  // up on the left
            if (last[row] > -1e9) add({first[row], double(top + row)}, turn);
        if (hull.size() > 1 && hull.back().x == hull[0].x && hull.back().y == hull[0].y) hull.pop_back();
        return hull;
    }

private:
    std::vector<double> first, last;
    std::vector<Point> hull;

    void add(const Point& p, std::size_t from) {
        if (hull.size() > from && hull.back().x == p.x && hull.back().y == p.y) return;
        while (hull.size() >= from + 2 && cross(hull[hull.size() - 2], hull.back(), p) <= 0) hull.pop_back();
        hull.push_back(p);
    }
};

// Removes sides of a convex polygon until four are left: each time that for which extending its neighbours until they
// meet adds the least area. False if the neighbours of no side meet.
bool four_sides(std::vector<Point>& p) {
    while (p.size() > 4) {
        const int n = p.size();
        int best = -1;
        double least = 0, best_along = 0;
        for (int i = 0; i < n; ++i) {
            const Point &a = p[(i + n - 1) % n], &b = p[i], &c = p[(i + 1) % n], &d = p[(i + 2) % n];
            const double ux = b.x - a.x, uy = b.y - a.y, wx = c.x - b.x, wy = c.y - b.y, vx = d.x - c.x, vy = d.y - c.y;
            const double both = ux * vy - uy * vx, turn = ux * wy - uy * wx, next = wx * vy - wy * vx;
            if (both == 0 || both * turn < 0 || both * next < 0) continue;
            const double along = next / both, area = along * std::fabs(turn);
            if (best < 0 || area < least) best = i, least = area, best_along = along;
        }
        if (best < 0) return false;
        const Point &a = p[(best + n - 1) % n], b = p[best];
        p[best] = {b.x + best_along * (b.x - a.x), b.y + best_along * (b.y - a.y)};
        p.erase(p.begin() + (best + 1) % n);
    }
    return true;
}

// Adds points of the shrunk image, converted to the full one.
void add_points(const Point* points, int count, double shrink, std::vector<double>& out) {
    for (int i = 0; i < count; ++i) {
        out.push_back((points[i].x + 0.5) * shrink - 0.5);
        out.push_back((points[i].y + 0.5) * shrink - 0.5);
    }
}

// Adds a quad, clockwise, if it is large and square enough.
void add_quad(const Point* p, double shrink, const Thresholds& limit, std::vector<double>& quads) {
    const double area = 0.5 * ((p[0].x - p[2].x) * (p[1].y - p[3].y) - (p[0].y - p[2].y) * (p[1].x - p[3].x));
    double shortest = 1e18, longest = 0;
    for (int i = 0; i < 4; ++i) {
        const double x = p[(i + 1) % 4].x - p[i].x, y = p[(i + 1) % 4].y - p[i].y, square = x * x + y * y;
        shortest = std::min(shortest, square), longest = std::max(longest, square);
    }
    const double smallest = limit.MIN_OUTLINE_SIDE / shrink;
    if (!(std::fabs(area) >= smallest * smallest)
        || !(shortest * limit.MAX_ASPECT * limit.MAX_ASPECT > longest))
        return;
    const Point turned[4] = {p[3], p[2], p[1], p[0]};
    add_points(area < 0 ? turned : p, 4, shrink, quads);
}

class QuadFinder {
public:
    void operator()(const std::vector<Point>& outline, double shrink, const Thresholds& limit,
                    std::vector<double>& quads) {
        double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9, area = 0;
        const Point* before = &outline.back();
        for (const Point& p : outline) {
            left = std::min(left, p.x), right = std::max(right, p.x);
            top = std::min(top, p.y), bottom = std::max(bottom, p.y);
            area += before->x * p.y - before->y * p.x;
            before = &p;
        }
        const double width = right - left + 1, height = bottom - top + 1, smaller = std::min(width, height);
        if (smaller < limit.MIN_OUTLINE_SIDE || 0.5 * std::fabs(area) < limit.MIN_FILLED * width * height) return;
        const int stride = std::max<int>(1, outline.size() / kHullPoints);
        const auto& shape = hull(outline, stride, int(top), int(height));
        polygon = simplified(shape, std::max(1.0, limit.POLYGON_TOLERANCE * (width + height)));
        const int count = polygon.size();
        if (count < 4 || count > limit.MAX_POLYGON_CORNERS) return;
        quad = polygon;
        if (four_sides(quad)) add_quad(quad.data(), shrink, limit, quads);
        if (count > 4 && count < 7 && smaller > 2 * limit.MIN_OUTLINE_SIDE)
            for (int i = 0; i < count; ++i) {
                const Point &a = polygon[(i + count - 2) % count], &b = polygon[(i + count - 1) % count], &c = polygon[i];
                const Point corners[4] = {a, b, c, {a.x + c.x - b.x, a.y + c.y - b.y}};
                add_quad(corners, shrink, limit, quads);
            }
    }

private:
    Hull hull;
    Simplifier simplified;
    std::vector<Point> polygon, quad;
};

// The means of the windows of 2 `reach` + 1 around the pixels of an image (height, width); beyond it lies its edge.
std::vector<std::uint8_t> means(const std::vector<std::uint8_t>& image, int width, int height, int reach) {
    const int window = 2 * reach + 1;
    std::vector<int> rows(image.size());
    std::vector<std::uint8_t> out(image.size());
    const auto sum = [&](int length, const auto& at, const auto& put) {
        int total = 0;
        for (int i = -reach; i <= reach; ++i) total += at(std::min(std::max(i, 0), length - 1));
        for (int i = 0; i < length; ++i) {
            put(i, total);
            total += at(std::min(i + reach + 1, length - 1)) - at(std::max(i - reach, 0));
        }
    };
    for (int y = 0; y < height; ++y)
        sum(width, [&](int x) { return image[y * width + x]; }, [&](int x, int total) { rows[y * width + x] = total; });
    for (int x = 0; x < width; ++x)
        sum(height, [&](int y) { return rows[y * width + x]; },
            [&](int y, int total) { out[y * width + x] = total / (window * window); });
    return out;
}

// Where a small square may be, and by how much it is brighter all around than inside
struct SmallPlace {
    double x, y, rise;
};

constexpr int kRays = 8, kNear = 6, kFar = 4, kRaySteps = 10;  // inside: the first steps; around: those from kFar on

// How much brighter it is around a place than inside along all rays but one; 0 if that is little beside the best one
double rise_around(const Image& smooth, double x, double y, double side, const Thresholds& limit) {
    static const double kX[kRays] = {1, 0.7071, 0, -0.7071, -1, -0.7071, 0, 0.7071};
    int rises[kRays];
    for (int ray = 0; ray < kRays; ++ray) {
        int bright = 0, dark = 255;
        for (int step = 0; step < kRaySteps; ++step) {
            const double away = (0.15 + 0.1 * step) * side;
            const int column = std::lround(x + kX[ray] * away), row = std::lround(y + kX[(ray + 6) % kRays] * away);
            const int grey = smooth.greys[std::min(std::max(row, 0), smooth.height - 1) * smooth.stride
                                          + std::min(std::max(column, 0), smooth.width - 1)];
            if (step >= kFar) bright = std::max(bright, grey);
            if (step < kNear) dark = std::min(dark, grey);
        }
        rises[ray] = bright - dark;
    }
    std::sort(rises, rises + kRays);
    return rises[1] >= limit.SMALL_RISE_SHARE * rises[kRays - 1] ? rises[1] : 0;
}

}  // namespace

std::vector<double> alvar::small_squares(const Image& smooth, int count, const double* quads, const Thresholds& limit) {
    constexpr double kApart = 3;             // px between places, along an axis
    constexpr int kReach = 11, kFine = 2;    // px around a place, and in a pixel
    std::vector<SmallPlace> places;
    for (const double* q = quads; q < quads + 8 * count; q += 8) {
        const double side = std::sqrt(std::fabs(area(q)));
        if (!(side > limit.SMALL_SIDE.low && side < limit.SMALL_SIDE.high)) continue;
        SmallPlace at = {(q[0] + q[2] + q[4] + q[6]) / 4, (q[1] + q[3] + q[5] + q[7]) / 4, 0};
        if (std::any_of(places.begin(), places.end(), [&](const SmallPlace& other) {
                return std::fabs(at.x - other.x) < kApart && std::fabs(at.y - other.y) < kApart;
            }))
            continue;
        at.rise = rise_around(smooth, at.x, at.y, std::max(side, 9.0), limit);
        if (at.rise >= limit.SMALL_RISE) places.push_back(at);
    }
    std::stable_sort(places.begin(), places.end(),
                     [](const SmallPlace& a, const SmallPlace& b) { return a.rise > b.rise; });
    if (places.size() > limit.MAX_SMALL) places.resize(limit.MAX_SMALL);
    std::vector<double> found, near;
    QuadFinder find_quads;
    for (const SmallPlace& at : places) {
        const int left = std::max(int(at.x) - kReach, 0), top = std::max(int(at.y) - kReach, 0);
        const int width = kFine * (std::min(int(at.x) + kReach + 1, smooth.width) - left);
        const int height = kFine * (std::min(int(at.y) + kReach + 1, smooth.height) - top);
        std::vector<std::uint8_t> fine(width * height);
        float x[kFine * (2 * kReach + 1)], y[kFine * (2 * kReach + 1)], grey[kFine * (2 * kReach + 1)];
        for (int row = 0; row < height; ++row) {
            for (int i = 0; i < width; ++i)
                x[i] = left + (i + 0.5f) / kFine - 0.5f, y[i] = top + (row + 0.5f) / kFine - 0.5f;
            for (int i = 0; i < width; i += kBlock) smooth.read(x + i, y + i, std::min(kBlock, width - i), grey + i);
            for (int i = 0; i < width; ++i) fine[row * width + i] = std::lround(grey[i]);
        }
        const auto range = std::minmax_element(fine.begin(), fine.end());
        const int offset = std::max<int>(3, limit.SMALL_OFFSET * (*range.second - *range.first));
        const std::vector<std::uint8_t> mean = means(fine, width, height, kReach);
        near.clear();
        Borders({fine.data(), width, width, height}, {mean.data(), width, width, height}, offset)
            .each([&](const std::vector<Point>& outline, bool outer) {
                if (outer && outline.size() >= 4 * limit.MIN_OUTLINE_SIDE)
                    find_quads(outline, 1.0 / kFine, limit, near);
            });
        for (double* q = near.data(); q < near.data() + near.size(); q += 8) {
            for (int k = 0; k < 8; ++k) q[k] += k % 2 ? top : left;
            const double side = std::sqrt(std::fabs(area(q)));
            if (side > limit.SMALL_SIDE.low && side < limit.SMALL_SIDE.high + 1
                && std::hypot((q[0] + q[2] + q[4] + q[6]) / 4 - at.x, (q[1] + q[3] + q[5] + q[7]) / 4 - at.y)
                       < limit.SMALL_SIDE.low)
                found.insert(found.end(), q, q + 8);
        }
    }
    return found;
}

Outlines alvar::outlines_of(const Image& smooth, const Image& mean, int offset, double shrink, bool parted,
                            const Thresholds& limit) {
    Outlines found;
    QuadFinder find_quads;
    Simplifier simplified;
    Borders(smooth, mean, offset).each([&](const std::vector<Point>& outline, bool outer) {
        if (parted && outline.size() >= limit.MIN_BROKEN_OUTLINE) {
            const auto& polygon = simplified(outline, limit.PART_TOLERANCE);
            for (std::size_t i = 0; i < polygon.size(); ++i) {
                const Point ends[2] = {polygon[(i + 1) % polygon.size()], polygon[i]};
                const double x = ends[0].x - ends[1].x, y = ends[0].y - ends[1].y;
                if (x * x + y * y >= limit.MIN_PART * limit.MIN_PART) add_points(ends, 2, shrink, found.parts);
            }
        }
        if (outer && outline.size() >= 4 * limit.MIN_OUTLINE_SIDE) find_quads(outline, shrink, limit, found.quads);
    });
    return found;
}
