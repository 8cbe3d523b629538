// broken_outlines.distinct_parts and broken_outlines.squares
#include <complex>
#include <cstring>

#include "algebra.h"
#include "steps.h"

namespace {

using namespace alvar;

typedef std::complex<double> Place;  // x + i y

struct Part {
    Place start, along;  // along has length 1
    double length;
};

struct Corner {
    int first, second;  // the parts before and after it
    Place at;
    double missing;  // share of both parts
};

struct Square {
    Place corners[4];
    double shown;
};

double dot(const Place& a, const Place& b) { return a.real() * b.real() + a.imag() * b.imag(); }
double cross(const Place& a, const Place& b) { return a.real() * b.imag() - a.imag() * b.real(); }

// The longest parts of each direction, by direction and then by length.
std::vector<Part> longest(int count, const double* parts, const Thresholds& limit) {
    std::vector<std::pair<int, Part>> all;
    for (int i = 0; i < count; ++i) {
        const double* p = parts + 4 * i;
        const Place step(p[2] - p[0], p[3] - p[1]);
        const double length = std::abs(step);
        const int sector = std::floor(std::arg(step) * (limit.DIRECTIONS / (2 * M_PI)));
        all.push_back({sector, {Place(p[0], p[1]), step / length, length}});
    }
    std::stable_sort(all.begin(), all.end(), [](const std::pair<int, Part>& a, const std::pair<int, Part>& b) {
        return a.first != b.first ? a.first < b.first : a.second.length > b.second.length;
    });
    std::vector<Part> chosen;
    int same = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
        same = i && all[i].first == all[i - 1].first ? same + 1 : 0;
        if (same < limit.MAX_PARTS) chosen.push_back(all[i].second);
    }
    return chosen;
}

// Adds the parts that follow when parts of one line are joined across gaps.
void join(std::vector<Part>& parts, const Thresholds& limit) {
    const int count = parts.size();
    for (int i = 0; i < count; ++i) {
        const Part one = parts[i];
        double low = 0, high = 0;
        for (int j = 0; j < count; ++j) {
            const Part& other = parts[j];
            if (!(dot(one.along, other.along) > limit.JOINED_TURN)) continue;
            const Place turned = (other.start - one.start) * std::conj(one.along);
            const double begin = turned.real(), end = begin + other.length;
            const double off = std::fabs((turned + 0.5 * other.length * other.along * std::conj(one.along)).imag());
            const double gap = std::max(begin, 0.0) - std::min(end, one.length);
            if (off < limit.JOINED_OFF && gap < limit.JOINED_GAP * std::max(one.length, other.length))
                low = std::min(low, begin), high = std::max(high, end);
        }
        if (high - low > one.length + limit.MIN_PART) parts.push_back({one.start + low * one.along, one.along, high - low});
    }
}

std::vector<Corner> corners_of(const std::vector<Part>& parts, const Thresholds& limit) {
    std::vector<Corner> corners;
    const int count = parts.size();
    for (int i = 0; i < count; ++i)
        for (int j = 0; j < count; ++j) {
            const Part &a = parts[i], &b = parts[j];
            const double turn = cross(a.along, b.along);
            if (!(turn > limit.MIN_TURN)) continue;
            const double reach = limit.CORNER_GAP * std::max(a.length, b.length) + 2;
            const Place between = b.start - a.start;
            const double before = cross(between, b.along) / turn - a.length;  // from the end of a to the corner
            const double after = cross(between, a.along) / turn;  // from the start of b to the corner
            if (std::fabs(before) >= reach || before <= -limit.CORNER_SPARE * a.length - 3
                || after >= limit.CORNER_SPARE * b.length + 3 || after <= -reach)
                continue;
            const double missing = (std::fabs(before) + std::fabs(after)) / (a.length + b.length);
            corners.push_back({i, j, a.start + (before + a.length) * a.along, missing});
        }
    std::stable_sort(corners.begin(), corners.end(),
                     [](const Corner& a, const Corner& b) { return a.missing < b.missing; });
    if (corners.size() > limit.MAX_CORNERS) corners.resize(limit.MAX_CORNERS);
    return corners;
}

Place meeting(const Part& a, const Part& b) {
    const double turn = cross(a.along, b.along);
    return a.start + cross(b.start - a.start, b.along) / (turn == 0 ? 1e-12 : turn) * a.along;
}

// Whether two corners face each other as those of a square do; then sets the square.
bool facing(const std::vector<Part>& parts, const Corner& a, const Corner& b, const Thresholds& limit, Square& out) {
    const Part* sides[4] = {&parts[a.first], &parts[a.second], &parts[b.first], &parts[b.second]};
    if (!(dot(sides[0]->along, sides[2]->along) < -limit.MIN_OPPOSITE)
        || !(dot(sides[1]->along, sides[3]->along) < -limit.MIN_OPPOSITE)
        || !(dot(b.at - a.at, sides[1]->along) > 0) || !(dot(a.at - b.at, sides[3]->along) > 0))
        return false;
    const Place corners[4] = {meeting(*sides[3], *sides[0]), a.at, meeting(*sides[1], *sides[2]), b.at};
    double width[4], all = 0, shown = 0;
    for (int k = 0; k < 4; ++k) {
        width[k] = dot(corners[(k + 1) % 4] - corners[k], sides[k]->along);
        all += width[k], shown += sides[k]->length;
        const double from = dot(sides[k]->start - corners[k], sides[k]->along);
        const double beyond = limit.CORNER_SPARE * width[k] + 3;
        if (!(from > -beyond) || !(from + sides[k]->length < width[k] + beyond)) return false;
    }
    const double least = *std::min_element(width, width + 4), most = *std::max_element(width, width + 4);
    out.shown = shown / std::max(all, 1e-12);
    std::copy(corners, corners + 4, out.corners);
    return least > limit.MIN_BROKEN_SIDE && most < limit.MAX_ASPECT * least && out.shown > limit.MIN_SHOWN;
}

}  // namespace

int alvar::distinct_parts(const Image& smooth, int count, double* parts, const Thresholds& limit) {
    static const double kPlaces[3] = {0.2, 0.5, 0.8};  // along a part, where it is read
    int kept = 0;
    for (int i = 0; i < count; ++i) {
        const double* p = parts + 4 * i;
        const double x = p[2] - p[0], y = p[3] - p[1], scale = limit.PART_SIDE / std::hypot(x, y);
        const double left_x = y * scale, left_y = -x * scale;
        float across[6], down[6], grey[6], contrast[3];
        for (int k = 0; k < 6; ++k) {
            const double sign = k < 3 ? -1 : 1;
            across[k] = p[0] + kPlaces[k % 3] * x + sign * left_x, down[k] = p[1] + kPlaces[k % 3] * y + sign * left_y;
        }
        smooth.read(across, down, 6, grey);
        for (int k = 0; k < 3; ++k) contrast[k] = (grey[k + 3] - grey[k]) / (grey[k + 3] + grey[k] + limit.DARK_GREY);
        if (!(nth(contrast, 3, 1) > limit.MIN_LOCAL_CONTRAST)) continue;
        std::memmove(parts + 4 * kept++, p, 4 * sizeof *p);
    }
    return kept;
}

std::vector<double> alvar::squares(int count, const double* parts, const Thresholds& limit) {
    std::vector<Part> all = longest(count, parts, limit);
    join(all, limit);
    const std::vector<Corner> corners = corners_of(all, limit);
    std::vector<Square> found;
    Square square;
    for (std::size_t i = 0; i < corners.size(); ++i)
        for (std::size_t j = i + 1; j < corners.size(); ++j)
            if (facing(all, corners[i], corners[j], limit, square)) found.push_back(square);
    std::stable_sort(found.begin(), found.end(), [](const Square& a, const Square& b) { return a.shown > b.shown; });
    if (found.size() > limit.MAX_BROKEN) found.resize(limit.MAX_BROKEN);
    std::vector<double> quads;
    for (const Square& each : found)
        for (const Place& corner : each.corners) quads.push_back(corner.real()), quads.push_back(corner.imag());
    return quads;
}
