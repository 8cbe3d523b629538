// visible_from of core/visibility.py, and the runs that core/faces.py finds in its layers. The formulas, their order
// and so every bit of the layers are those of the Python files.
#include <algorithm>
#include <limits>
#include <vector>

#include "scene.h"

namespace {

using namespace robotont;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool in_view(const Solid& solid, const Camera& camera, const Pose& pose) {
    const double dx = solid.x - pose.x, dy = solid.y - pose.y;
    const double ahead = pose.cos * dx + pose.sin * dy, right = pose.sin * dx - pose.cos * dy;
    const double first = camera.right[0], last = camera.right[camera.width - 1];
    return ahead + solid.reach > camera.near && right - first * ahead > -solid.reach * std::hypot(1.0, first)
           && last * ahead - right > -solid.reach * std::hypot(1.0, last);
}

// Where the rays of all columns enter and leave a solid: depths [m], face of entry, incidence.
struct Crossing {
    std::int32_t index;
    const Solid* solid;
    double over_top, over_bottom;
    double *enter, *leave, *incidence;  // (width,)
    std::int32_t* face;
};

ROBOTONT_INLINE double no_zero(double direction) { return std::fabs(direction) < 1e-12 ? 1e-12 : direction; }

ROBOTONT_FAST void cross_box(const Crossing& out, const Camera& camera, const Pose& pose) {
    const CameraInFrame eye(*out.solid, pose);
    const double half_x = out.solid->half_x, half_y = out.solid->half_y;
    double *enter = out.enter, *leave = out.leave, *incidence = out.incidence;
    std::int32_t* face = out.face;
    for (std::int64_t i = 0; i < camera.width; ++i) {
        const double dx = no_zero(eye.forward_x + eye.right_x * camera.right[i]);
        const double dy = no_zero(eye.forward_y + eye.right_y * camera.right[i]);
        const double middle_x = -eye.x / dx, reach_x = half_x / std::fabs(dx);
        const double middle_y = -eye.y / dy, reach_y = half_y / std::fabs(dy);
        const double enter_x = middle_x - reach_x, enter_y = middle_y - reach_y;
        const double leave_x = middle_x + reach_x, leave_y = middle_y + reach_y;
        const bool by_x = enter_x > enter_y;
        const double across = by_x ? dx : dy;
        enter[i] = by_x ? enter_x : enter_y;
        leave[i] = leave_x < leave_y ? leave_x : leave_y;
        incidence[i] = std::fabs(across);
        face[i] = (by_x ? kLeftOfX : kLeftOfY) + (across < 0);  // each right one follows its left one
    }
}

void cross_cylinder(const Crossing& out, const Camera& camera, const Pose& pose) {
    const CameraInFrame eye(*out.solid, pose);
    const double radius = out.solid->radius;
    for (std::int64_t i = 0; i < camera.width; ++i) {
        const double dx = eye.forward_x + eye.right_x * camera.right[i];
        const double dy = eye.forward_y + eye.right_y * camera.right[i];
        const double square = dx * dx + dy * dy, middle = -(eye.x * dx + eye.y * dy) / square;
        const double aside = eye.x * dy - eye.y * dx, miss = aside * aside / square;
        const double part = (radius * radius - miss) / square, reach = part >= 0 ? std::sqrt(part) : -1.0;
        out.enter[i] = middle - reach, out.leave[i] = middle + reach;
        out.incidence[i] = 1.0, out.face[i] = kRound;
    }
}

struct Hit {
    const Crossing* crossing;
    double near, leave, key, upper, lower;
};

struct Piece {
    double key, upper, lower;
    const Crossing* crossing;
    double depth;
    Kind kind;
};

class Column {
  public:
    Column(const Camera& camera, const Pose& pose) : camera_(camera), pose_(pose) {}

    // Finds the pieces in a column, nearest first.
    void look(const std::vector<Crossing>& crossings, std::int64_t column) {
        hits_.clear(), pieces.clear();
        for (const Crossing& one : crossings) {
            const double enter = one.enter[column], leave = one.leave[column];
            if (!(enter < leave && leave > camera_.near)) continue;
            const double near = enter > camera_.near ? enter : camera_.near;
            hits_.push_back({&one, near, leave, near - camera_.tie * one.solid->rank,
                             camera_.cy + one.over_top / near, camera_.cy + one.over_bottom / near});
            const Hit& hit = hits_.back();
            if (enter > camera_.near) add(hit, kFront, hit.upper, hit.lower, hit.key);
        }
        for (const Hit& hit : hits_) {
            if (hit.crossing->solid->top < pose_.z) add_end(hit, kTop);
            if (hit.crossing->solid->bottom > pose_.z) add_end(hit, kUnder);
        }
    }

    std::vector<Piece> pieces;

  private:
    void add(const Hit& hit, Kind kind, double upper, double lower, double key) {
        const Piece piece = {key, upper, lower, hit.crossing, hit.near, kind};
        auto place = pieces.end();
        while (place != pieces.begin() && (place - 1)->key > key) --place;
        pieces.insert(place, piece);
    }

    // Adds the upper or lower end of a solid, in pieces: those behind what stands in it are drawn before that.
    void add_end(const Hit& hit, Kind kind) {
        const Solid& solid = *hit.crossing->solid;
        const double over = kind == kTop ? hit.crossing->over_top : hit.crossing->over_bottom;
        double start = hit.near, key = hit.key + 0.5 * camera_.tie;
        while (key < kInfinity) {
            double end = hit.leave > start ? hit.leave : start, next = kInfinity;
            const Hit* first = nullptr;
            for (const Hit& other : hits_) {
                const Solid& its = *other.crossing->solid;
                if (!(kind == kTop ? its.top > solid.top : its.bottom < solid.bottom)) continue;
                if (other.near > start && other.near < end && !(first && other.near >= first->near)) first = &other;
            }
            if (first) end = first->near, next = first->key + 0.75 * camera_.tie;
            const double near_row = camera_.cy + over / start, far_row = camera_.cy + over / end;
            if (kind == kTop)
                add(hit, kind, far_row, std::min(near_row + camera_.seam, std::max(near_row, hit.lower)), key);
            else
                add(hit, kind, std::max(near_row - camera_.seam, std::min(near_row, hit.upper)), far_row, key);
            start = end, key = next;
        }
    }

    const Camera& camera_;
    const Pose& pose_;
    std::vector<Hit> hits_;
};

void clear_layer(const Layers& out, std::int64_t layer, std::int64_t width) {
    const std::int64_t begin = layer * width, end = begin + width;
    std::fill(out.solid + begin, out.solid + end, -1);
    std::fill(out.kind + begin, out.kind + end, kFront);
    std::fill(out.face + begin, out.face + end, kRound);
    for (double* values : {out.upper, out.lower}) std::fill(values + begin, values + end, 0.0);
    for (double* values : {out.depth, out.incidence}) std::fill(values + begin, values + end, 1.0);
}

// Writes the pieces that are seen into their layers; returns how many layers there are.
std::int64_t lay(const std::vector<Piece>& pieces, const Camera& camera, std::int64_t column, Layers& out) {
    double covered = kInfinity, floor_from = camera.cy;
    std::int64_t layer = 0;
    for (const Piece& piece : pieces) {
        const bool closed = piece.crossing->solid->bottom <= 0.0;
        const double clipped = piece.upper > -0.5 ? piece.upper : -0.5;
        if (clipped < std::min(covered, camera.height - 0.5) && clipped < piece.lower) {
            if (layer < out.capacity) {
                if (layer == out.count) clear_layer(out, out.count++, camera.width);
                const std::int64_t at = layer * camera.width + column;
                out.solid[at] = piece.crossing->index, out.kind[at] = piece.kind;
                out.face[at] = piece.crossing->face[column];
                out.upper[at] = piece.upper, out.lower[at] = piece.lower;
                out.depth[at] = piece.depth, out.incidence[at] = piece.crossing->incidence[column];
            }
            ++layer;
        }
        if (closed) {
            covered = std::min(covered, clipped);
            if (piece.upper <= camera.cy) floor_from = std::max(floor_from, piece.lower);
        }
    }
    out.floor_from[column] = floor_from;
    return layer;
}

int level(const Solid& solid, double size) {
    int found = 0;
    while (found < kLevels && size >= solid.steps[found]) ++found;
    return found;
}

// Adds the runs of a layer; beyond the capacity they are only counted.
void add_runs(const Solid* solids, const Camera& camera, std::int64_t layer, Layers& out) {
    Run run = {static_cast<std::int32_t>(layer), 0, 0, -1, 0, 0, 0, 0};
    const auto end_at = [&](std::int32_t column) {
        if (run.solid >= 0) {
            run.right = column;
            if (out.run_count < out.run_capacity) out.runs[out.run_count] = run;
            ++out.run_count;
        }
    };
    for (std::int32_t column = 0; column < camera.width; ++column) {
        const std::int64_t at = layer * camera.width + column;
        const std::int32_t index = out.solid[at], kind = out.kind[at], face = out.face[at];
        std::int32_t along = 0, up = 0;
        if (index >= 0 && kind == kFront && !std::isnan(solids[index].size[face])) {
            const double size = solids[index].size[face] * out.depth[at];
            along = level(solids[index], size / out.incidence[at]), up = level(solids[index], size);
        }
        if (index != run.solid || kind != run.kind || face != run.face || along != run.along || up != run.up) {
            end_at(column);
            run = {static_cast<std::int32_t>(layer), column, column, index, kind, face, along, up};
        }
    }
    end_at(static_cast<std::int32_t>(camera.width));
}

}  // namespace

// Returns whether there was room for all; `out` then says how many layers and runs there are, else how many are needed.
extern "C" int robotont_visible(const Camera* camera, const Pose* pose, const Solid* solids, int count, Layers* out) {
    const std::int64_t width = camera->width;
    std::vector<std::int32_t> order;
    for (const bool box : {true, false})
        for (int k = 0; k < count; ++k)
            if ((solids[k].box > 0) == box && in_view(solids[k], *camera, *pose)) order.push_back(k);
    std::vector<double> numbers(3 * width * order.size());
    std::vector<std::int32_t> faces(width * order.size());
    std::vector<Crossing> crossings;
    double* next = numbers.data();
    for (std::size_t k = 0; k < order.size(); ++k, next += 3 * width) {
        const Solid& solid = solids[order[k]];
        const Crossing one = {order[k], &solid, (pose->z - solid.top) * camera->focal,
                              (pose->z - solid.bottom) * camera->focal, next, next + width, next + 2 * width,
                              faces.data() + k * width};
        solid.box > 0 ? cross_box(one, *camera, *pose) : cross_cylinder(one, *camera, *pose);
        crossings.push_back(one);
    }
    Column column(*camera, *pose);
    std::int64_t needed = 0;
    out->count = out->run_count = 0;
    for (std::int64_t i = 0; i < width; ++i) {
        column.look(crossings, i);
        needed = std::max(needed, lay(column.pieces, *camera, i, *out));
    }
    if (needed > out->capacity) {
        out->count = needed;
        return 0;
    }
    for (std::int64_t layer = 0; layer < out->count; ++layer) add_runs(solids, *camera, layer, *out);
    return out->run_count <= out->run_capacity;
}
