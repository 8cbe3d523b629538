// What is drawn, and the steps that draw it. The camera is level and all solids are upright, so each column of the
// picture is a line of the floor plan. Lengths and depths in metres, depths along the optical axis; rows and columns in
// pixels, whole numbers at their centres.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

namespace robotont {

// Compiled twice on x86: for every processor, and for those with AVX2; the better one is chosen when it is loaded.
#if !defined(ROBOTONT_FAST)
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define ROBOTONT_FAST __attribute__((target_clones("default", "avx2")))
#else
#define ROBOTONT_FAST
#endif
#endif
#define ROBOTONT_INLINE inline __attribute__((always_inline))

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kTie = 1e-7;      // [m] by which a higher solid counts as nearer if two faces are in one plane
constexpr double kSeam = 1.0;      // [px] by which an end overlaps the upright face beside it, so that there is no gap
constexpr double kSteepest = 4.0;  // [px/column] an edge is blended over as many rows as it rises, at most these
constexpr int kCoarsest = 12;      // a pattern's image is halved at most this many times

using Colour = std::uint32_t;  // red + 256 green + 65536 blue
using Rgb = std::array<double, 3>;

enum Kind { kFront, kTop, kUnder };  // an upright face, the upper and the lower end of a solid
enum Face { kLeftOfX, kRightOfX, kLeftOfY, kRightOfY, kRound, kFaces };  // a box's own -x, +x, -y, +y; a cylinder's

struct Camera {
    int width, height;
    double focal, cx, cy, near;
    std::vector<double> right, down;  // x / z of each column, y / z of each row

    Camera(int width, int height, double focal, double cx, double cy, double near)
        : width(width), height(height), focal(focal), cx(cx), cy(cy), near(near), right(width), down(height) {
        for (int column = 0; column < width; ++column) right[column] = (column - cx) / focal;
        for (int row = 0; row < height; ++row) down[row] = (row - cy) / focal;
    }
};

struct Pose {
    double x, y, z, yaw, cos, sin;

    Pose(double x, double y, double z, double yaw)
        : x(x), y(y), z(z), yaw(yaw), cos(std::cos(yaw)), sin(std::sin(yaw)) {}
    bool operator==(const Pose& other) const {
        return x == other.x && y == other.y && z == other.z && yaw == other.yaw;
    }
};

struct Solid {
    bool box;
    double x, y, cos, sin, half_x, half_y, radius, bottom, top;
    double reach;       // [m] from its middle to its farthest side
    double rank = 0.0;  // of faces in one plane, that of the highest rank is seen
    std::array<Colour, kFaces> sides = {};
    Colour upper_end = 0, lower_end = 0;
    Rgb round = {};                         // the colour of a cylinder's curved face, without shade
    std::array<double, kFaces> resolution;  // [px/m] of each face's pattern; nan: it has none
    std::vector<double> levels;  // [pattern's px/px] the size from which on level 1, 2, ... of its image is taken

    static Solid make_box(double x, double y, double yaw, double length, double width, double bottom, double height) {
        return Solid(true, x, y, yaw, length / 2, width / 2, 0.0, std::hypot(length / 2, width / 2), bottom, height);
    }
    static Solid make_cylinder(double x, double y, double radius, double bottom, double height) {
        return Solid(false, x, y, 0.0, 0.0, 0.0, radius, radius, bottom, height);
    }

  private:
    Solid(bool box, double x, double y, double yaw, double half_x, double half_y, double radius, double reach,
          double bottom, double height)
        : box(box), x(x), y(y), cos(std::cos(yaw)), sin(std::sin(yaw)), half_x(half_x), half_y(half_y), radius(radius),
          bottom(bottom), top(bottom + height), reach(reach) {
        resolution.fill(std::numeric_limits<double>::quiet_NaN());
    }
};

// The images of a pattern's levels, `steps` of which halve the size; `sharper` halvings finer than the camera's pixels.
inline std::vector<double> level_sizes(int steps, double sharper) {
    std::vector<double> sizes;
    for (int level = 1; level <= kCoarsest * steps; ++level)
        sizes.push_back(std::pow(2.0, (level - 0.5) / steps + sharper));
    return sizes;
}

// The brightness of an upright face is upright + x normal_x + y normal_y.
struct Light {
    double upright, x, y;
};

// The camera's response: how much light each value of its pictures stands for, and back. What is blended is blended in
// light. Values are tones and the parts of a colour, 0 to 255; light is 0 to kFull, and more for each higher value.
struct Response {
    static constexpr int kValues = 256, kFull = 255 * 256;
    static constexpr int kBits = 8;  // each octave of light has 2**kBits places in `back`
    static constexpr std::uint32_t kDropped = 23 - kBits, kFirst = 127u << kBits;  // bits of a float; the place of 1.0
    std::array<std::uint16_t, kValues> light;
    std::array<std::uint32_t, (16 << kBits) + 1> back = {};  // in 1 / 256 value, at index_of(light)
    bool linear = true;                                      // light is values, in 1 / 256

    explicit Response(const std::array<std::uint16_t, kValues>& light) : light(light) {
        for (int value = 0; value < kValues; ++value) linear = linear && light[value] == value * 256;
        for (std::uint32_t k = 0; k < back.size(); ++k) {
            const std::uint32_t bits = (k + kFirst) << kDropped | 1u << (kDropped - 1);  // the middle of this place
            float next;
            std::memcpy(&next, &bits, sizeof next);
            const auto above = std::upper_bound(light.begin() + 1, light.end() - 1, next - 1);
            const double step = (next - 1 - above[-1]) / (above[0] - above[-1]);
            back[k] = static_cast<std::uint32_t>(256 * (above - light.begin() - 1 + std::min(step, 1.0)));
        }
        for (int value = 0; value < kValues; ++value) back[index_of(light[value])] = 256 * value;  // exactly
    }

    // Of a float, the exponent and kBits of the mantissa: so far apart are the values, even those of dark pixels
    static int index_of(std::uint32_t light) {
        const float next = static_cast<float>(light + 1);
        std::uint32_t bits;
        std::memcpy(&bits, &next, sizeof bits);
        return (bits >> kDropped) - kFirst;
    }
};

// Tones (height, width), and the same in light.
struct Tones {
    const std::uint8_t* tones = nullptr;
    const std::uint16_t* light = nullptr;
    int width = 0, height = 0;
};

// What a face shows: the tones of a pattern, or without them a colour.
struct Source : Tones {
    double along = 0.0, up = 0.0, top = 0.0, pad = 0.0;  // [px/m], [m] z of its upper edge; [px] around the pattern
    std::array<std::uint32_t, 3> tint = {};              // of the tones, in 1 / 65536
    Colour colour = 0;
    bool curved = false;  // the shaded side of a cylinder
};

struct FloorImage : Tones {  // one period of the floor, and a row and a column more
    int bits = 0;  // log2 of the period [px]
};

struct Background {
    std::vector<Colour> rows;         // the colour of each row that shows neither a solid nor the floor's pattern
    std::vector<FloorImage> floor;    // each half as fine as the previous one; none: a plain floor
    std::array<std::uint32_t, 3> tint;  // of the floor's tones
    double period;                    // [m]
    double sharpness;                 // pixels of the floor's image per pixel of the camera
};

// The content of one layer in each column; beside nearer layers, it is visible between the rows upper and lower.
struct Layer {
    std::vector<int> solid, kind, face;  // solid: -1 where the layer is empty
    std::vector<double> upper, lower, depth, incidence;  // of the upright face; incidence of the ray: |cosine| / z

    explicit Layer(int width)
        : solid(width), kind(width), face(width), upper(width), lower(width), depth(width), incidence(width) {}
};

struct Run {  // columns of one layer that show the same face, from an image with these levels
    int layer, left, right, solid, kind, face, along, up;
};

struct Visible {
    std::vector<Layer> layers;  // nearest first, of which `count` are in use
    int count = 0;
    std::vector<Run> runs;  // nearest layer first
};

// The camera in the frame of a solid: position, unit vectors forward and to the right.
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

// visibility.cpp: what is seen in each column, and in which runs.
void find_visible(const Camera& camera, const Pose& pose, const std::vector<Solid>& solids, Visible* out);

// picture.cpp: pixels (height, width, 3), RGB or with `bgr` BGR; sources: of each run.
struct Picture {
    const Camera& camera;
    const Pose& pose;
    const std::vector<Solid>& solids;
    const Visible& visible;
    const std::vector<const Source*>& sources;
    const Background& background;
    const Light& light;
    const Response& response;
};
void draw_picture(const Picture& picture, bool bgr, std::uint8_t* pixels);

// depth.cpp: depths (height, width), nan unless between `near` and `far`.
void draw_depth(const Camera& camera, const Pose& pose, const std::vector<Solid>& solids, const Visible& visible,
                double near, double far, float* out);

}  // namespace robotont
