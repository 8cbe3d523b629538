// candidates.refined, candidates.distinct, candidates.in_turn and uneven_light.free_of
#include <cstring>
#include <numeric>

#include "algebra.h"
#include "steps.h"

namespace {

using namespace alvar;

constexpr int kAlong = 5, kAcross = 13, kRises = kAcross - 2;
const float kPlaces[kAlong] = {0.12f, 0.31f, 0.5f, 0.69f, 0.88f};  // along a side, as shares of its length

struct Side {
    float x, y, along_x, along_y, normal_x, normal_y;
    float offset[kAlong], weight[kAlong], typical;
};

void read_side(const Image& smooth, Side& side, float reach, float nearness) {
    float across[kAlong * kAcross], down[kAlong * kAcross], grey[kAlong * kAcross];
    for (int i = 0; i < kAlong; ++i) {
        const float x = side.x + kPlaces[i] * side.along_x, y = side.y + kPlaces[i] * side.along_y;
        for (int k = 0; k < kAcross; ++k) {
            const float at = (k - kAcross / 2) * (reach / (kAcross / 2));
            across[i * kAcross + k] = x + at * side.normal_x, down[i * kAcross + k] = y + at * side.normal_y;
        }
    }
    smooth.read(across, down, kAlong * kAcross, grey);
    for (int i = 0; i < kAlong; ++i) {
        const float* here = grey + i * kAcross;
        int best = 0;
        float most = -1e9f;
        for (int k = 0; k < kRises; ++k) {
            const float at = (k + 1 - kAcross / 2) / float(kAcross / 2);
            const float rise = (here[k + 2] - here[k]) * (1 - nearness * at * at);
            if (rise > most) most = rise, best = k;
        }
        side.offset[i] = (best + 1 - kAcross / 2) / float(kAcross / 2);
        side.weight[i] = most;
    }
    float sorted[kAlong];
    std::memcpy(sorted, side.weight, sizeof sorted);
    side.typical = nth(sorted, kAlong, kAlong / 2);
}

// Moves a side onto a robust line through its offsets.
void move(Side& side, float reach, float outliers) {
    float sorted[kAlong];
    std::memcpy(sorted, side.offset, sizeof sorted);
    float middle = nth(sorted, kAlong, kAlong / 2), slope = 0;
    for (int again = 0; again < 2; ++again) {
        float s0 = 0, s1 = 0, s2 = 0, y0 = 0, y1 = 0;
        for (int i = 0; i < kAlong; ++i) {
            const float t = kPlaces[i] - 0.5f, r = outliers * (side.offset[i] - middle - slope * t);
            const float w = std::max(side.weight[i], 0.5f) / ((1 + r * r) * (1 + r * r));
            s0 += w, s1 += w * t, s2 += w * t * t, y0 += w * side.offset[i], y1 += w * t * side.offset[i];
        }
        s2 += 0.02f * s0;
        const float det = s0 * s2 - s1 * s1;
        middle = (y0 * s2 - y1 * s1) / det, slope = (s0 * y1 - s1 * y0) / det;
    }
    const float shift = (middle - 0.5f * slope) * reach;
    side.x += shift * side.normal_x, side.y += shift * side.normal_y;
    side.along_x += slope * reach * side.normal_x, side.along_y += slope * reach * side.normal_y;
}

// Whether the corners of two quads are nearer than `reach` along both axes, whichever comes first.
bool alike(const double* a, const double* b, double reach) {
    for (int turn = 0; turn < 4; ++turn) {
        bool near = true;
        for (int k = 0; near && k < 4; ++k)
            for (int axis = 0; axis < 2; ++axis)
                near = near && std::fabs(a[2 * k + axis] - b[2 * ((k + turn) % 4) + axis]) < reach;
        if (near) return true;
    }
    return false;
}

}  // namespace

int alvar::refine_sides(const Image& smooth, int count, double* quads, const Thresholds& limit, Trail* trail) {
    int kept = 0;
    for (int m = 0; m < count; ++m) {
        const double* q = quads + 8 * m;
        const float reach = limit.SIDE_REACH * std::sqrt(std::fabs(area(q)));
        Side sides[4];
        float typical[4];
        int flat = 0;
        for (int k = 0; k < 4 && (flat < 2 || trail); ++k) {  // two are enough
            Side& side = sides[k];
            const int next = (k + 1) % 4;
            side.x = q[2 * k], side.y = q[2 * k + 1];
            side.along_x = q[2 * next] - q[2 * k], side.along_y = q[2 * next + 1] - q[2 * k + 1];
            const float length = std::sqrt(side.along_x * side.along_x + side.along_y * side.along_y);
            side.normal_x = side.along_y / length, side.normal_y = -side.along_x / length;
            read_side(smooth, side, reach, limit.SIDE_NEARNESS);
            typical[k] = side.typical;
            flat += !(side.typical > limit.MIN_SIDE_RISE);
        }
        if (flat >= 2) {
            if (trail) end_at(trail, q, {"MIN_SIDE_RISE", nth(typical, 4, 1), limit.MIN_SIDE_RISE});
            continue;
        }
        for (Side& side : sides) move(side, reach, limit.SIDE_OUTLIERS);
        double* out = quads + 8 * kept++;
        for (int k = 0; k < 4; ++k) {  // where each side meets the one before it
            const Side &p = sides[(k + 3) % 4], &s = sides[k];
            const float cross = p.along_x * s.along_y - p.along_y * s.along_x;
            const float part = ((s.x - p.x) * s.along_y - (s.y - p.y) * s.along_x) / (std::fabs(cross) < 1e-9f ? 1e-9f : cross);
            out[2 * k] = p.x + part * p.along_x, out[2 * k + 1] = p.y + part * p.along_y;
        }
    }
    return kept;
}

std::vector<int> alvar::distinct(const double* quads, const double* score, std::vector<int> which,
                                 const Thresholds& limit) {
    std::stable_sort(which.begin(), which.end(), [&](int a, int b) { return score[a] > score[b]; });
    std::vector<int> kept;
    std::vector<double> sides;  // of those
    for (const int i : which) {
        const double* quad = quads + 8 * i;
        const double side = std::sqrt(std::fabs(area(quad)));
        bool known = false;
        for (std::size_t k = 0; k < kept.size() && !known; ++k)
            known = alike(quad, quads + 8 * kept[k], limit.SAME_QUAD * std::min(side, sides[k]));
        if (!known) kept.push_back(i), sides.push_back(side);
    }
    return kept;
}

std::vector<int> alvar::in_turn(const double* quads, const std::vector<int>& which, const Turn& turn) {
    const std::int64_t count = which.size();
    std::vector<int> order(count);
    std::iota(order.begin(), order.end(), 0);
    if (count <= turn.most) return order;
    // by what changes little from image to image: how far down they are
    const auto down = [&](int place) {
        const double* quad = quads + 8 * which[place];
        return quad[1] + quad[3] + quad[5] + quad[7];
    };
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return down(a) < down(b); });
    std::rotate(order.begin(), order.begin() + turn.first % count, order.end());
    order.resize(turn.most);
    std::sort(order.begin(), order.end());
    return order;
}

std::vector<std::uint8_t> alvar::free_of(const std::vector<double>& squares, int count, const double* points) {
    std::vector<std::uint8_t> free(count);
    for (int i = 0; i < count; ++i) {
        bool inside = false;
        for (const double* s = squares.data(); !inside && s < squares.data() + squares.size(); s += 3)
            inside = std::fabs(points[2 * i] - s[0]) <= s[2] && std::fabs(points[2 * i + 1] - s[1]) <= s[2];
        free[i] = !inside;
    }
    return free;
}
