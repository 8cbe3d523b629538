// Which faces are visible in each column, nearest first. A column is one line of the floor plan, which is inside each
// solid from one depth to another; the rows of the solid follow from these two depths. Order and occlusion are
// therefore exact in each column, even for solids that overlap.
#include <algorithm>

#include "scene.h"

namespace robotont {
namespace {

bool in_view(const Solid& solid, const Camera& camera, const Pose& pose) {
    const double dx = solid.x - pose.x, dy = solid.y - pose.y;
    const double ahead = pose.cos * dx + pose.sin * dy, right = pose.sin * dx - pose.cos * dy;
    const double first = camera.right.front(), last = camera.right.back();
    return ahead + solid.reach > camera.near && right - first * ahead > -solid.reach * std::hypot(1.0, first)
           && last * ahead - right > -solid.reach * std::hypot(1.0, last);
}

// Where the rays of all columns enter and leave a solid: depths [m], face of entry, incidence.
struct Crossing {
    int index;
    const Solid* solid;
    double over_top, over_bottom;  // [m px] of its ends over the camera: so many rows at a depth of 1 m
    std::vector<double> enter, leave, incidence;
    std::vector<int> face;

    Crossing(int index, const Solid& solid, const Camera& camera, const Pose& pose)
        : index(index), solid(&solid), over_top((pose.z - solid.top) * camera.focal),
          over_bottom((pose.z - solid.bottom) * camera.focal), enter(camera.width), leave(camera.width),
          incidence(camera.width), face(camera.width) {}
};

ROBOTONT_INLINE double no_zero(double direction) { return std::fabs(direction) < 1e-12 ? 1e-12 : direction; }

ROBOTONT_FAST void cross_box(Crossing* out, const Camera& camera, const Pose& pose) {
    const CameraInFrame eye(*out->solid, pose);
    const double half_x = out->solid->half_x, half_y = out->solid->half_y, *right = camera.right.data();
    double *enter = out->enter.data(), *leave = out->leave.data(), *incidence = out->incidence.data();
    int* face = out->face.data();
    const int width = camera.width;
    for (int i = 0; i < width; ++i) {
        const double dx = no_zero(eye.forward_x + eye.right_x * right[i]);
        const double dy = no_zero(eye.forward_y + eye.right_y * right[i]);
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

void cross_cylinder(Crossing* out, const Camera& camera, const Pose& pose) {
    const CameraInFrame eye(*out->solid, pose);
    const double radius = out->solid->radius;
    for (int i = 0; i < camera.width; ++i) {
        const double dx = eye.forward_x + eye.right_x * camera.right[i];
        const double dy = eye.forward_y + eye.right_y * camera.right[i];
        const double square = dx * dx + dy * dy, middle = -(eye.x * dx + eye.y * dy) / square;
        const double aside = eye.x * dy - eye.y * dx, miss = aside * aside / square;
        const double part = (radius * radius - miss) / square, reach = part >= 0 ? std::sqrt(part) : -1.0;
        out->enter[i] = middle - reach, out->leave[i] = middle + reach;
        out->incidence[i] = 1.0, out->face[i] = kRound;
    }
}

struct Hit {
    const Crossing* crossing;
    double near, leave, key, upper, lower;
};

struct Piece {
    double key, upper, lower;  // pieces are drawn in the order of their keys [m]
    const Crossing* crossing;
    double depth;
    Kind kind;
};

class Column {
  public:
    Column(const Camera& camera, const Pose& pose) : camera_(camera), pose_(pose) {}

    // Finds the pieces in a column, nearest first.
    void find(const std::vector<Crossing>& crossings, int column) {
        hits_.clear(), pieces.clear();
        for (const Crossing& one : crossings) {
            const double enter = one.enter[column], leave = one.leave[column];
            if (!(enter < leave && leave > camera_.near)) continue;
            const double near = enter > camera_.near ? enter : camera_.near;
            hits_.push_back({&one, near, leave, near - kTie * one.solid->rank,
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
        double start = hit.near, key = hit.key + 0.5 * kTie;
        while (key < kInfinity) {
            double end = hit.leave > start ? hit.leave : start, next = kInfinity;
            const Hit* first = nullptr;
            for (const Hit& other : hits_) {
                const Solid& its = *other.crossing->solid;
                if (!(kind == kTop ? its.top > solid.top : its.bottom < solid.bottom)) continue;
                if (other.near > start && other.near < end && !(first && other.near >= first->near)) first = &other;
            }
            if (first) end = first->near, next = first->key + 0.75 * kTie;
            const double near_row = camera_.cy + over / start, far_row = camera_.cy + over / end;
            if (kind == kTop)
                add(hit, kind, far_row, std::min(near_row + kSeam, std::max(near_row, hit.lower)), key);
            else
                add(hit, kind, std::max(near_row - kSeam, std::min(near_row, hit.upper)), far_row, key);
            start = end, key = next;
        }
    }

    const Camera& camera_;
    const Pose& pose_;
    std::vector<Hit> hits_;
};

// Writes the pieces that are seen into their layers.
void lay(const std::vector<Piece>& pieces, const Camera& camera, int column, Visible* out) {
    double covered = camera.height - 0.5;  // the highest row below which all is covered
    int layer = 0;
    for (const Piece& piece : pieces) {
        const double clipped = piece.upper > -0.5 ? piece.upper : -0.5;
        if (clipped < covered && clipped < piece.lower) {
            if (layer == static_cast<int>(out->layers.size())) out->layers.emplace_back(camera.width);
            Layer& into = out->layers[layer];
            if (layer == out->count) std::fill(into.solid.begin(), into.solid.end(), -1), ++out->count;
            ++layer;
            into.solid[column] = piece.crossing->index, into.kind[column] = piece.kind;
            into.face[column] = piece.crossing->face[column];
            into.upper[column] = piece.upper, into.lower[column] = piece.lower;
            into.depth[column] = piece.depth, into.incidence[column] = piece.crossing->incidence[column];
        }
        if (piece.crossing->solid->bottom <= 0.0) covered = std::min(covered, clipped);
    }
}

int level(const Solid& solid, double size) {
    int found = 0;
    while (found < static_cast<int>(solid.levels.size()) && size >= solid.levels[found]) ++found;
    return found;
}

void add_runs(const Camera& camera, const std::vector<Solid>& solids, int number, Visible* out) {
    const Layer& layer = out->layers[number];
    Run run = {number, 0, 0, -1, 0, 0, 0, 0};
    const auto end_at = [&](int column) {
        run.right = column;
        if (run.solid >= 0) out->runs.push_back(run);
    };
    for (int i = 0; i < camera.width; ++i) {
        Run next = {number, i, i, layer.solid[i], layer.kind[i], layer.face[i], 0, 0};
        if (next.solid >= 0 && next.kind == kFront && !std::isnan(solids[next.solid].resolution[next.face])) {
            const Solid& solid = solids[next.solid];
            const double size = solid.resolution[next.face] / camera.focal * layer.depth[i];
            next.along = level(solid, size / layer.incidence[i]), next.up = level(solid, size);
        }
        if (next.solid != run.solid || next.kind != run.kind || next.face != run.face || next.along != run.along
            || next.up != run.up) {
            end_at(i);
            run = next;
        }
    }
    end_at(camera.width);
}

}  // namespace

void find_visible(const Camera& camera, const Pose& pose, const std::vector<Solid>& solids, Visible* out) {
    std::vector<Crossing> crossings;
    for (const bool box : {true, false})
        for (std::size_t k = 0; k < solids.size(); ++k)
            if (solids[k].box == box && in_view(solids[k], camera, pose)) {
                crossings.emplace_back(static_cast<int>(k), solids[k], camera, pose);
                box ? cross_box(&crossings.back(), camera, pose) : cross_cylinder(&crossings.back(), camera, pose);
            }
    Column column(camera, pose);
    out->count = 0, out->runs.clear();
    for (int i = 0; i < camera.width; ++i) {
        column.find(crossings, i);
        lay(column.pieces, camera, i, out);
    }
    for (int layer = 0; layer < out->count; ++layer) add_runs(camera, solids, layer, out);
}

}  // namespace robotont
