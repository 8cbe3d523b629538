// The depth image: the floor, and on it the layers, the farthest first.
#include <algorithm>

#include "scene.h"

namespace robotont {
namespace {

struct Range {
    double near, far;

    float reported(double depth) const {
        return depth > near && depth < far ? static_cast<float>(depth) : std::numeric_limits<float>::quiet_NaN();
    }
};

// The depth of a horizontal end at `level` [m] in a row.
double depth_of(double level, double down, const Pose& pose) { return (pose.z - level) / (down == 0.0 ? 1e-9 : down); }

ROBOTONT_FAST void draw_row(float* out, const float* values, const int* first, const int* end, int columns, int row) {
    for (int i = 0; i < columns; ++i) out[i] = row >= first[i] && row < end[i] ? values[i] : out[i];
}

void draw_floor(const Camera& camera, const Pose& pose, const Range& range, float* out) {
    for (int row = 0; row < camera.height; ++row) {
        const double down = camera.down[row], depth = down > 0.0 ? pose.z / std::max(down, 1e-9) : kInfinity;
        std::fill_n(out + row * camera.width, camera.width, range.reported(depth));
    }
}

}  // namespace

void draw_depth(const Camera& camera, const Pose& pose, const std::vector<Solid>& solids, const Visible& visible,
                double near, double far, float* out) {
    const Range range = {near, far};
    const double height = camera.height;
    std::vector<float> values(camera.width);
    std::vector<int> first(camera.width), end(camera.width);
    draw_floor(camera, pose, range, out);
    for (auto run = visible.runs.rbegin(); run != visible.runs.rend(); ++run) {
        const Layer& layer = visible.layers[run->layer];
        const int left = run->left, columns = run->right - left;
        int top = camera.height, bottom = 0;
        for (int i = left; i < run->right; ++i) {
            first[i] = static_cast<int>(std::ceil(std::min(std::max(layer.upper[i], 0.0), height)));
            end[i] = static_cast<int>(std::ceil(std::min(std::max(layer.lower[i], 0.0), height)));
            top = std::min(top, first[i]), bottom = std::max(bottom, end[i]);
            values[i] = range.reported(layer.depth[i]);
        }
        const Solid& solid = solids[run->solid];
        for (int row = top; row < bottom; ++row) {
            if (run->kind != kFront) {
                const double level = run->kind == kTop ? solid.top : solid.bottom;
                std::fill_n(&values[left], columns, range.reported(depth_of(level, camera.down[row], pose)));
            }
            draw_row(out + row * camera.width + left, &values[left], &first[left], &end[left], columns, row);
        }
    }
}

}  // namespace robotont
