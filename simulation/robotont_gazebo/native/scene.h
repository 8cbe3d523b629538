// What is drawn and where from, as core/native.py fills it in; names are those of core/visibility.py and core/faces.py.
#pragma once
#include <cmath>
#include <cstdint>

namespace robotont {

// Compiled twice on x86: for every processor, and for those with AVX2; the better one is chosen when it is loaded.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define ROBOTONT_FAST __attribute__((target_clones("default", "avx2")))
#else
#define ROBOTONT_FAST
#endif
#define ROBOTONT_INLINE inline __attribute__((always_inline))

enum Kind { kFront, kTop, kUnder };
enum Face { kLeftOfX, kRightOfX, kLeftOfY, kRightOfY, kRound };
constexpr int kFaces = kRound + 1, kLevels = 24;

struct Solid {
    double box, x, y, cos, sin, half_x, half_y, radius, bottom, top, reach, rank;
    double size[kFaces];     // [pattern's px/px] of a face 1 m away; nan: plain
    double steps[kLevels];  // the size from which on level 1, 2, ... of the pattern's image is taken
};

struct Run {  // columns of one layer that show the same face, of an image with these levels
    std::int32_t layer, left, right, solid, kind, face, along, up;
};

struct Camera {
    std::int64_t width, height;
    double focal, cx, cy, near, tie, seam;
    const double* right;  // (width,)
};

struct Pose {
    double x, y, z, cos, sin;
};

// Arrays (capacity, width), but floor_from (width,), in which the first `count` layers are valid; and runs.
struct Layers {
    std::int64_t capacity, run_capacity, count, run_count;
    std::int32_t *solid, *kind, *face;
    double *upper, *lower, *depth, *incidence, *floor_from;
    Run* runs;
};

// The camera in the frame of a solid: visibility.in_frame_at.
struct CameraInFrame {
    double x, y, forward_x, forward_y, right_x, right_y;

    CameraInFrame(const Solid& solid, const Pose& pose) {
        const double dx = pose.x - solid.x, dy = pose.y - solid.y;
        forward_x = solid.cos * pose.cos + solid.sin * pose.sin;
        forward_y = solid.cos * pose.sin - solid.sin * pose.cos;
        x = solid.cos * dx + solid.sin * dy, y = solid.cos * dy - solid.sin * dx;
        right_x = forward_y, right_y = -forward_x;
    }
};

}  // namespace robotont
