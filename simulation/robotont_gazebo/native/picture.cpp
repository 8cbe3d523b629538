// The picture of the layers that visibility.cpp has found: what core/backdrop.py, faces.py and layers.py draw, in
// blocks of columns. Greys between those of a pattern's image differ from cv2.warpPerspective's by their rounding.
#include <algorithm>
#include <cstring>
#include <vector>

#include "scene.h"

namespace {

using namespace robotont;

constexpr int kBlock = 8, kPart = 256;  // columns; parts of a pixel of a pattern's image
constexpr bool kLittleEndian = __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__;
typedef std::uint32_t Words __attribute__((vector_size(4 * kBlock)));
typedef std::int32_t Integers __attribute__((vector_size(4 * kBlock)));
typedef float Floats __attribute__((vector_size(4 * kBlock)));
typedef std::uint8_t Bytes __attribute__((vector_size(4 * kBlock)));
constexpr Words kLanes = {0, 1, 2, 3, 4, 5, 6, 7};
// Three bytes of each colour, in the first twelve of each half
constexpr Bytes kPacked = {0,  1,  2,  4,  5,  6,  8,  9,  10, 12, 13, 14, 3,  7,  11, 15,
                           16, 17, 18, 20, 21, 22, 24, 25, 26, 28, 29, 30, 19, 23, 27, 31};
constexpr std::uint32_t kNothing = ~0u;

// What a run shows: tones (height, width) of a pattern, or a colour. Colours are R + 256 G + 65536 B.
struct Source {
    const std::uint8_t* tones;  // null: a plain colour
    std::int64_t width, height;
    double along, up, top;        // [px/m]; [m] z of the pattern's upper edge
    std::int64_t tint[3], plain;  // 1 / 65536 of the tones; the colour itself
    double round[3];              // the colour of a cylinder's curved face, without shade; negative: it is none
};

struct FloorImage {
    const std::uint8_t* tones;  // one period of the floor, and a row and a column more
    std::int64_t bits;          // log2 of the period [px]
};

struct Style {
    const std::uint32_t* rows;  // (height,): the colour of each row without solids and pattern
    const FloorImage* floor;
    double period, pad, steepest, upright, light_x, light_y;
    std::int64_t floor_tint[3];
};

struct Picture {
    std::uint8_t* pixels;  // (height, width, 3)
    std::int64_t blue_first;
    const std::uint8_t* levels;  // (height,): the floor's image that each row shows, 255: none
    const Source* sources;
    const std::int32_t* source_of_run;
};

// The colours of kBlock places: of four tones around each, which is `right` and `down` parts from the first one.
ROBOTONT_INLINE Words blend_tones(const std::uint8_t* tones, std::int32_t stride, const Integers& at,
                                  const Words& right, const Words& down, const std::int64_t* tint) {
    Words upper, lower;
    for (int i = 0; i < kBlock; ++i) {
        const std::uint8_t *p = tones + at[i], *q = p + stride;
        upper[i] = p[0] | p[1] << 8, lower[i] = q[0] | q[1] << 8;
    }
    const Words first = (upper & 255) * (kPart - right) + (upper >> 8) * right;
    const Words second = (lower & 255) * (kPart - right) + (lower >> 8) * right;
    const Words tone = (first * (kPart - down) + second * down + kPart / 2) / kPart;  // in parts of 1 / 256 grey
    const std::uint32_t r = tint[0], g = tint[1], b = tint[2], half = 1u << 23;
    return (tone * r + half) >> 24 | (tone * g + half) >> 24 << 8 | (tone * b + half) >> 24 << 16;
}

struct FloorRow {
    std::uint32_t x, y, across_x, across_y;  // of column 0, and from one column to the next: 2**32 is a period
};

std::uint32_t part_of_period(double value) {
    return static_cast<std::uint32_t>(static_cast<std::int64_t>((value - std::floor(value)) * 4294967296.0));
}

FloorRow floor_row(const Camera& camera, const Pose& pose, const Style& style, int level, int row) {
    const double depth = camera.focal * pose.z / (row - camera.cy), first = -camera.cx / camera.focal;
    const double half = 0.5 / (std::int64_t(1) << style.floor[level].bits);  // the middle of a pixel
    const double x = pose.x + depth * (pose.cos + first * pose.sin), y = pose.y + depth * (pose.sin - first * pose.cos);
    const double across = depth / camera.focal / style.period;
    return {part_of_period(x / style.period - half), part_of_period(y / style.period - half),
            part_of_period(across * pose.sin), part_of_period(-across * pose.cos)};
}

ROBOTONT_INLINE Words draw_floor(const FloorRow& row, const FloorImage& image, std::int64_t left,
                                 const std::int64_t* tint) {
    const int shift = 32 - static_cast<int>(image.bits);
    const std::uint32_t stride = (1u << image.bits) + 1;
    const Words x = row.x + (static_cast<std::uint32_t>(left) + kLanes) * row.across_x;
    const Words y = row.y + (static_cast<std::uint32_t>(left) + kLanes) * row.across_y;
    const Words at = (y >> shift) * stride + (x >> shift);
    return blend_tones(image.tones, stride, (Integers)at, x >> (shift - 8) & (kPart - 1),
                       y >> (shift - 8) & (kPart - 1), tint);
}

// The edges of one layer, as layers.LayerMask has them, (width,) each.
struct Mask {
    std::vector<double> upper, lower, wide_upper, wide_lower;
    std::vector<std::int32_t> first, end;

    Mask(const Layers& layers, std::int64_t layer, const Camera& camera, double steepest)
        : upper(camera.width), lower(camera.width), wide_upper(camera.width, 1.0), wide_lower(camera.width, 1.0),
          first(camera.width), end(camera.width) {
        const std::int64_t width = camera.width, begin = layer * width;
        const std::int32_t *solid = layers.solid + begin, *kind = layers.kind + begin, *face = layers.face + begin;
        const double *above = layers.upper + begin, *below = layers.lower + begin;
        const double height = static_cast<double>(camera.height);
        for (std::int64_t i = 0; i + 1 < width; ++i)
            if (solid[i] >= 0 && solid[i] == solid[i + 1] && kind[i] == kind[i + 1] && face[i] == face[i + 1]) {
                const double rise = std::fabs(above[i + 1] - above[i]), fall = std::fabs(below[i + 1] - below[i]);
                wide_upper[i] = std::max(wide_upper[i], rise), wide_upper[i + 1] = std::max(1.0, rise);
                wide_lower[i] = std::max(wide_lower[i], fall), wide_lower[i + 1] = std::max(1.0, fall);
            }
        for (std::int64_t i = 0; i < width; ++i) {
            wide_upper[i] = std::min(wide_upper[i], steepest), wide_lower[i] = std::min(wide_lower[i], steepest);
            upper[i] = std::min(std::max(above[i], -steepest), height + steepest);
            lower[i] = std::min(std::max(below[i], -steepest), height + steepest);
            const double from = std::ceil(upper[i] + 0.5 * wide_upper[i]);
            const double to = std::floor(lower[i] - 0.5 * wide_lower[i]) + 1;
            const bool present = solid[i] >= 0;
            first[i] = static_cast<std::int32_t>(present ? std::min(std::max(from, 0.0), height) : height);
            end[i] = static_cast<std::int32_t>(present ? std::min(std::max(to, 0.0), height) : 0.0);
        }
    }

    // How much of a pixel is covered, in 1 / 256.
    ROBOTONT_INLINE int share(std::int64_t column, int row) const {
        const double from_upper = (row - upper[column]) / wide_upper[column] + 0.5;
        const double to_lower = (lower[column] - row) / wide_lower[column] + 0.5;
        const double part = std::min(std::max(from_upper, 0.0), 1.0) + std::min(std::max(to_lower, 0.0), 1.0) - 1.0;
        return part > 0 ? static_cast<int>(std::nearbyint(part * 256)) : 0;
    }
};

ROBOTONT_INLINE std::uint32_t blended(std::uint32_t under, std::uint32_t drawn, int share) {
    std::uint32_t out = 0;
    for (int shift = 0; shift < 24; shift += 8) {
        const int old = under >> shift & 255, fresh = drawn >> shift & 255;
        out |= static_cast<std::uint32_t>(old + ((fresh - old) * share >> 8)) << shift;
    }
    return out;
}

// Up to kBlock columns of a run.
struct Part {
    const Source* source;
    std::int64_t left, columns;
    Integers column;     // of the pattern's image
    Words right;         // parts of a pixel more
    Floats start, down;  // its row at the picture's row 0, and how many more a row further
    Words colour;

    Part(const Source& what, std::int64_t first, std::int64_t end, const double* depth, const Solid& solid, int face,
         const Camera& camera, const Pose& pose, const Style& style)
        : source(&what), left(first), columns(end - first) {
        const CameraInFrame eye(solid, pose);
        for (int i = 0; i < kBlock; ++i) {
            const std::int64_t at = std::min<std::int64_t>(first + i, end - 1);
            const double slope = camera.right[at], z = depth[at];
            if (what.tones)
                place(i, along(eye, solid, face, slope, z), z, camera, pose, style);
            else
                colour[i] = what.round[0] < 0 ? static_cast<std::uint32_t>(what.plain)
                                              : curved(solid, slope, z, pose, style);
        }
    }

    // [m] along a face from its left edge to where a ray meets it.
    static double along(const CameraInFrame& eye, const Solid& solid, int face, double slope, double z) {
        const double x = eye.x + z * (eye.forward_x + slope * eye.right_x);
        const double y = eye.y + z * (eye.forward_y + slope * eye.right_y);
        switch (face) {
            case kLeftOfX: return solid.half_y - y;
            case kRightOfX: return solid.half_y + y;
            case kLeftOfY: return solid.half_x + x;
            default: return solid.half_x - x;
        }
    }

    void place(int i, double metres, double z, const Camera& camera, const Pose& pose, const Style& style) {
        const double offset = style.pad - 0.5, last = (source->width - 1.0) * kPart - 1;
        double across = (metres * source->along + offset) * kPart;
        across = across > 0 ? across : 0;
        across = across < last ? across : last;
        const std::int32_t whole = static_cast<std::int32_t>(across + 0.5);
        column[i] = whole / kPart, right[i] = whole % kPart;
        const double each = z / camera.focal * source->up;
        down[i] = static_cast<float>(each);
        start[i] = static_cast<float>((source->top - pose.z) * source->up - camera.cy * each + offset
                                      + 0.5 / kPart);
    }

    std::uint32_t curved(const Solid& solid, double slope, double z, const Pose& pose, const Style& style) const {
        const double aside = z * slope;
        const double normal_x = (pose.x + z * pose.cos + aside * pose.sin - solid.x) / solid.radius;
        const double normal_y = (pose.y + z * pose.sin - aside * pose.cos - solid.y) / solid.radius;
        const double shade = style.upright + style.light_x * normal_x + style.light_y * normal_y;
        std::uint32_t out = 0;
        for (int k = 0; k < 3; ++k) {
            const double value = std::min(std::max(std::nearbyint(source->round[k] * shade), 0.0), 255.0);
            out |= static_cast<std::uint32_t>(value) << 8 * k;
        }
        return out;
    }

    ROBOTONT_INLINE Words draw(int row) const {
        if (!source->tones) return colour;
        const std::int32_t stride = static_cast<std::int32_t>(source->width);
        const float last = static_cast<float>((source->height - 1) * kPart - 1);
        Floats place = (start + static_cast<float>(row) * down) * kPart;
        place = place > 0 ? place : 0;
        place = place < last ? place : last;
        const Integers whole = __builtin_convertvector(place, Integers);
        return blend_tones(source->tones, stride, (whole >> 8) * stride + column, right,
                           (Words)(whole & (kPart - 1)), source->tint);
    }
};

// The columns from `left` on, at most kBlock, of all rows.
class Block {
  public:
    Block(const Camera& camera, std::int64_t height) : camera_(camera), colours_(height * kBlock), cover_(height) {}

    void begin(std::int64_t left, const std::vector<Mask>& masks) {
        left_ = left, columns_ = std::min<std::int64_t>(kBlock, camera_.width - left);
        std::fill(cover_.begin(), cover_.end(), kNothing);
        for (std::size_t layer = 0; layer < masks.size(); ++layer) {
            const std::int32_t *first = &masks[layer].first[left], *end = &masks[layer].end[left];
            const std::int32_t from = *std::max_element(first, first + columns_);
            const std::int32_t to = *std::min_element(end, end + columns_);
            for (std::int32_t row = from; row < to; ++row) cover_[row] = std::min<std::uint32_t>(cover_[row], layer);
        }
    }

    ROBOTONT_INLINE void draw_background(const Style& style, const Picture& picture, const FloorRow* floor) {
        for (std::int64_t row = 0; row < camera_.height; ++row) {
            if (cover_[row] != kNothing) continue;
            std::uint32_t* out = &colours_[row * kBlock];
            if (picture.levels[row] == 255)
                std::fill(out, out + kBlock, style.rows[row]);
            else {
                const Words drawn = draw_floor(floor[row], style.floor[picture.levels[row]], left_, style.floor_tint);
                std::memcpy(out, &drawn, sizeof drawn);
            }
        }
    }

    // Draws columns of a run of a layer, all of which are in this block.
    ROBOTONT_INLINE void draw(const Part& part, std::uint32_t layer, const Mask& mask) {
        int top = static_cast<int>(camera_.height), bottom = 0, first = 0, end = top;
        for (std::int64_t i = part.left; i < part.left + part.columns; ++i) {
            first = std::max(first, mask.first[i]), end = std::min(end, mask.end[i]);
            top = std::min(top, static_cast<int>(std::floor(mask.upper[i] - 0.5 * mask.wide_upper[i])));
            bottom = std::max(bottom, static_cast<int>(std::ceil(mask.lower[i] + 0.5 * mask.wide_lower[i])) + 1);
        }
        const int height = static_cast<int>(camera_.height);
        for (int row = std::max(top, 0); row < std::min(bottom, height); ++row) {
            if (cover_[row] < layer) continue;
            std::uint32_t* out = &colours_[row * kBlock + part.left - left_];
            const Words drawn = part.draw(row);
            if (row >= first && row < end && part.columns == kBlock)
                std::memcpy(out, &drawn, sizeof drawn);
            else
                for (int i = 0; i < part.columns; ++i) {
                    const std::int64_t column = part.left + i;
                    const bool whole = row >= mask.first[column] && row < mask.end[column];
                    out[i] = whole ? drawn[i] : blended(out[i], drawn[i], mask.share(column, row));
                }
        }
    }

    ROBOTONT_INLINE void write(const Picture& picture) const {
        for (std::int64_t row = 0; row < camera_.height; ++row) {
            Words colours;
            std::memcpy(&colours, &colours_[row * kBlock], sizeof colours);
            if (picture.blue_first) colours = (colours & 0xff00) | colours >> 16 | (colours & 255) << 16;
            std::uint8_t* out = picture.pixels + (row * camera_.width + left_) * 3;
            if (kLittleEndian && columns_ == kBlock) {
                Bytes bytes;
                std::memcpy(&bytes, &colours, sizeof bytes);
                bytes = __builtin_shuffle(bytes, kPacked);
                std::memcpy(out, &bytes, 12);
                std::memcpy(out + 12, reinterpret_cast<const std::uint8_t*>(&bytes) + 16, 12);
            } else
                for (std::int64_t i = 0; i < 3 * columns_; ++i)
                    out[i] = static_cast<std::uint8_t>(colours[i / 3] >> 8 * (i % 3));
        }
    }

  private:
    const Camera& camera_;
    std::int64_t left_ = 0, columns_ = 0;
    std::vector<std::uint32_t> colours_, cover_;  // (height, kBlock); (height,): the nearest layer that hides the rest
};

}  // namespace

extern "C" ROBOTONT_FAST void robotont_picture(const Camera* camera, const Pose* pose, const Solid* solids,
                                               const Layers* layers, const Style* style, const Picture* picture) {
    std::vector<Mask> masks;
    for (std::int64_t layer = 0; layer < layers->count; ++layer)
        masks.emplace_back(*layers, layer, *camera, style->steepest);
    std::vector<FloorRow> floor(camera->height);
    for (int row = 0; row < camera->height; ++row)
        if (picture->levels[row] != 255) floor[row] = floor_row(*camera, *pose, *style, picture->levels[row], row);
    Block block(*camera, camera->height);
    for (std::int64_t left = 0; left < camera->width; left += kBlock) {
        block.begin(left, masks);
        block.draw_background(*style, *picture, floor.data());
        for (std::int64_t k = layers->run_count - 1; k >= 0; --k) {  // the farthest layer first
            const Run& run = layers->runs[k];
            const std::int64_t first = std::max<std::int64_t>(left, run.left);
            const std::int64_t end = std::min<std::int64_t>(left + kBlock, run.right);
            if (first >= end) continue;
            const Source& source = picture->sources[picture->source_of_run[k]];
            const Part part(source, first, end, layers->depth + run.layer * camera->width, solids[run.solid], run.face,
                            *camera, *pose, *style);
            block.draw(part, run.layer, masks[run.layer]);
        }
        block.write(*picture);
    }
}
