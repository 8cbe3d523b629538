// The depth image of the layers that visibility.cpp has found: Renderer._draw_depth of core/renderer.py, to the bit.
#include <algorithm>
#include <limits>
#include <vector>

#include "scene.h"

namespace {

using namespace robotont;

struct Range {
    double near, far;

    float reported(double depth) const {
        return depth > near && depth < far ? static_cast<float>(depth) : std::numeric_limits<float>::quiet_NaN();
    }
};

// The depth of a horizontal end at `level` [m] in a row.
double depth_of(double level, double down, const Pose& pose) { return (pose.z - level) / (down == 0.0 ? 1e-9 : down); }

ROBOTONT_FAST void draw_row(float* out, const float* values, const std::int32_t* first, const std::int32_t* end,
                            std::int64_t columns, std::int32_t row) {
    for (std::int64_t i = 0; i < columns; ++i) out[i] = row >= first[i] && row < end[i] ? values[i] : out[i];
}

}  // namespace

// Writes the layers into `out` (height, width), which has the floor in it; down (height,): y / z of each row.
extern "C" void robotont_depth(const Camera* camera, const Pose* pose, const Solid* solids, const Layers* layers,
                               const double* down, double near, double far, float* out) {
    const Range range = {near, far};
    const double height = static_cast<double>(camera->height);
    std::vector<float> values(camera->width);
    std::vector<std::int32_t> first(camera->width), end(camera->width);
    for (std::int64_t k = layers->run_count - 1; k >= 0; --k) {  // the farthest layer first
        const Run& run = layers->runs[k];
        const std::int64_t begin = run.layer * camera->width, columns = run.right - run.left;
        std::int32_t top = static_cast<std::int32_t>(camera->height), bottom = 0;
        for (std::int32_t i = run.left; i < run.right; ++i) {
            first[i] = static_cast<std::int32_t>(std::ceil(std::min(std::max(layers->upper[begin + i], 0.0), height)));
            end[i] = static_cast<std::int32_t>(std::ceil(std::min(std::max(layers->lower[begin + i], 0.0), height)));
            top = std::min(top, first[i]), bottom = std::max(bottom, end[i]);
            values[i] = range.reported(layers->depth[begin + i]);
        }
        const Solid& solid = solids[run.solid];
        for (std::int32_t row = top; row < bottom; ++row) {
            if (run.kind != kFront) {
                const double level = run.kind == kTop ? solid.top : solid.bottom;
                std::fill(values.begin() + run.left, values.begin() + run.right,
                          range.reported(depth_of(level, down[row], *pose)));
            }
            draw_row(out + row * camera->width + run.left, &values[run.left], &first[run.left], &end[run.left], columns,
                     row);
        }
    }
}

// For native.py: which arguments the steps of this library take
extern "C" int robotont_interface() { return ROBOTONT_INTERFACE; }
