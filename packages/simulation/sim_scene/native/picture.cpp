// The picture, in blocks of columns: sky and floor, and on them the layers, the farthest first. Each face is drawn by
// the perspective map of its plane, from an image of its pattern in a size that suits the distance. Its upper and lower
// edges are blended by how much of a pixel they cover; upright edges fall between two columns. Tones and
// edges are blended in light.
#include <algorithm>
#include <cstring>

#include "scene.h"

namespace robotont {
namespace {

using Tint = std::array<std::uint32_t, 3>;
constexpr int kBlock = 8, kPart = 256;  // columns; parts of a pixel of a pattern's image
constexpr bool kLittleEndian = __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__;
typedef std::uint32_t Words __attribute__((vector_size(4 * kBlock)));
typedef std::uint64_t Longs __attribute__((vector_size(4 * kBlock)));
typedef std::int32_t Integers __attribute__((vector_size(4 * kBlock)));
typedef float Floats __attribute__((vector_size(4 * kBlock)));
typedef std::uint8_t Bytes __attribute__((vector_size(4 * kBlock)));
constexpr Words kLanes = {0, 1, 2, 3, 4, 5, 6, 7};
// Three bytes of each colour, in the first twelve of each half
constexpr Bytes kPacked = {0,  1,  2,  4,  5,  6,  8,  9,  10, 12, 13, 14, 3,  7,  11, 15,
                           16, 17, 18, 20, 21, 22, 24, 25, 26, 28, 29, 30, 19, 23, 27, 31};
constexpr int kNothing = std::numeric_limits<int>::max();  // more than the number of any layer
constexpr int kPlain = -1;  // the level of rows that do not show the floor's pattern

ROBOTONT_INLINE bool any(const Words& words) {
    const Longs halves = (Longs)words;
    return halves[0] | halves[1] | halves[2] | halves[3];
}

// kBlock places in an image, `right` and `down` parts of a pixel from the first of four tones around each.
struct Places {
    Integers first;
    Words right, down;
};

// The tones, in 1 / 256, of kBlock places. Not inline, as most places have four equal tones around them: drawing those
// would take longer, because fewer registers would be left for it.
ROBOTONT_FAST void blend_in_light(const Tones& image, const Response& response, const Places& places, Words* tone) {
    Words upper, lower;
    for (int i = 0; i < kBlock; ++i) {
        const std::uint16_t *p = image.light + places.first[i], *q = p + image.width;
        upper[i] = p[0] | static_cast<std::uint32_t>(p[1]) << 16;
        lower[i] = q[0] | static_cast<std::uint32_t>(q[1]) << 16;
    }
    const Words right = places.right, down = places.down;
    const Words first = (upper & 0xffff) * (kPart - right) + (upper >> 16) * right;
    const Words second = (lower & 0xffff) * (kPart - right) + (lower >> 16) * right;
    const Words light = (first * (kPart - down) + second * down + kPart * kPart / 2) / (kPart * kPart);
    const Floats next = __builtin_convertvector((Integers)(light + 1), Floats);
    const Words at = ((Words)next >> Response::kDropped) - Response::kFirst;  // Response::index_of
    Words out;
    for (int i = 0; i < kBlock; ++i) out[i] = response.back[at[i]];
    *tone = out;
}

// The colours of kBlock places, `right` and `down` parts from the first of four tones around each.
ROBOTONT_INLINE Words blend_tones(const Tones& image, const Response& response, const Integers& at, const Words& right,
                                  const Words& down, const Tint& tint) {
    Words upper, lower;
    for (int i = 0; i < kBlock; ++i) {
        const std::uint8_t *p = image.tones + at[i], *q = p + image.width;
        upper[i] = p[0] | p[1] << 8, lower[i] = q[0] | q[1] << 8;
    }
    Words tone = (upper & 255) << 8;  // in 1 / 256
    if (__builtin_expect(any((upper ^ lower) | ((upper >> 8 ^ upper) & 255)), false)) {
        if (response.linear) {
            const Words first = (upper & 255) * (kPart - right) + (upper >> 8) * right;
            const Words second = (lower & 255) * (kPart - right) + (lower >> 8) * right;
            tone = (first * (kPart - down) + second * down + kPart / 2) / kPart;
        } else {
            Words blended;
            blend_in_light(image, response, {at, right, down}, &blended);
            tone = blended;
        }
    }
    const std::uint32_t r = tint[0], g = tint[1], b = tint[2], half = 1u << 23;
    return (tone * r + half) >> 24 | (tone * g + half) >> 24 << 8 | (tone * b + half) >> 24 << 16;
}

struct FloorRow {
    int level;
    std::uint32_t x, y, across_x, across_y;  // of column 0, and from one column to the next: 2**32 is a period
};

std::uint32_t part_of_period(double value) {
    return static_cast<std::uint32_t>(static_cast<std::int64_t>((value - std::floor(value)) * 4294967296.0));
}

FloorRow floor_row(const Camera& camera, const Pose& pose, const Background& background, int level, int row) {
    const double depth = camera.focal * pose.z / (row - camera.cy), first = -camera.cx / camera.focal;
    const double half = 0.5 / (std::int64_t(1) << background.floor[level].bits);  // the middle of a pixel
    const double x = pose.x + depth * (pose.cos + first * pose.sin), y = pose.y + depth * (pose.sin - first * pose.cos);
    const double across = depth / camera.focal / background.period;
    return {level, part_of_period(x / background.period - half), part_of_period(y / background.period - half),
            part_of_period(across * pose.sin), part_of_period(-across * pose.cos)};
}

// All rows; a level of the floor is shown from the row below which it is fine enough, up to where the finer one begins.
std::vector<FloorRow> floor_rows(const Camera& camera, const Pose& pose, const Background& background) {
    std::vector<FloorRow> rows(camera.height, FloorRow{kPlain, 0, 0, 0, 0});
    if (!(pose.z > 0.0)) return rows;
    int end = camera.height;
    for (int level = 0; level < static_cast<int>(background.floor.size()); ++level) {
        const double resolution = std::ldexp(1.0, background.floor[level].bits) / background.period;  // [px/m]
        const double scale = background.sharpness / resolution;
        const double depth = std::pow(scale * camera.focal * std::sqrt(pose.z), 2.0 / 3.0);
        const double row = std::ceil(camera.cy + camera.focal * pose.z / depth);
        const int first = static_cast<int>(std::min(std::max(row, 0.0), static_cast<double>(end)));
        for (int k = first; k < end; ++k) rows[k] = floor_row(camera, pose, background, level, k);
        end = first;
    }
    return rows;
}

ROBOTONT_INLINE Words draw_floor(const FloorRow& row, const Background& background, int left,
                                 const Response& response) {
    const FloorImage& image = background.floor[row.level];
    const int shift = 32 - image.bits;
    const std::uint32_t stride = image.width;
    const Words x = row.x + (static_cast<std::uint32_t>(left) + kLanes) * row.across_x;
    const Words y = row.y + (static_cast<std::uint32_t>(left) + kLanes) * row.across_y;
    const Words at = (y >> shift) * stride + (x >> shift);
    return blend_tones(image, response, (Integers)at, x >> (shift - 8) & (kPart - 1), y >> (shift - 8) & (kPart - 1),
                       background.tint);
}

// The rows that one layer covers: in each column, `first` to `end` (exclusive) fully, some beside them partly.
struct Mask {
    std::vector<double> upper, lower, wide_upper, wide_lower;  // the edges, and over how many rows they are blended
    std::vector<int> first, end;

    Mask(const Layer& layer, const Camera& camera)
        : upper(camera.width), lower(camera.width), wide_upper(camera.width, 1.0), wide_lower(camera.width, 1.0),
          first(camera.width), end(camera.width) {
        const int *solid = layer.solid.data(), *kind = layer.kind.data(), *face = layer.face.data();
        const double *above = layer.upper.data(), *below = layer.lower.data(), height = camera.height;
        for (int i = 0; i + 1 < camera.width; ++i)
            if (solid[i] >= 0 && solid[i] == solid[i + 1] && kind[i] == kind[i + 1] && face[i] == face[i + 1]) {
                const double rise = std::fabs(above[i + 1] - above[i]), fall = std::fabs(below[i + 1] - below[i]);
                wide_upper[i] = std::max(wide_upper[i], rise), wide_upper[i + 1] = std::max(1.0, rise);
                wide_lower[i] = std::max(wide_lower[i], fall), wide_lower[i + 1] = std::max(1.0, fall);
            }
        for (int i = 0; i < camera.width; ++i) {
            wide_upper[i] = std::min(wide_upper[i], kSteepest), wide_lower[i] = std::min(wide_lower[i], kSteepest);
            upper[i] = std::min(std::max(above[i], -kSteepest), height + kSteepest);
            lower[i] = std::min(std::max(below[i], -kSteepest), height + kSteepest);
            const double from = std::ceil(upper[i] + 0.5 * wide_upper[i]);
            const double to = std::floor(lower[i] - 0.5 * wide_lower[i]) + 1;
            const bool present = solid[i] >= 0;
            first[i] = static_cast<int>(present ? std::min(std::max(from, 0.0), height) : height);
            end[i] = static_cast<int>(present ? std::min(std::max(to, 0.0), height) : 0.0);
        }
    }

    // How much of a pixel is covered, in 1 / 256.
    ROBOTONT_INLINE int share(int column, int row) const {
        const double from_upper = (row - upper[column]) / wide_upper[column] + 0.5;
        const double to_lower = (lower[column] - row) / wide_lower[column] + 0.5;
        const double part = std::min(std::max(from_upper, 0.0), 1.0) + std::min(std::max(to_lower, 0.0), 1.0) - 1.0;
        return part > 0 ? static_cast<int>(std::nearbyint(part * 256)) : 0;
    }
};

ROBOTONT_INLINE Colour blended(Colour under, Colour drawn, int share, const Response& response) {
    Colour out = 0;
    for (int shift = 0; shift < 24; shift += 8) {
        const int old = response.light[under >> shift & 255], fresh = response.light[drawn >> shift & 255];
        const std::uint32_t light = old + ((fresh - old) * share >> 8);
        out |= (response.linear ? light : response.back[Response::index_of(light)]) >> 8 << shift;
    }
    return out;
}

// Up to kBlock columns of a run.
struct Part {
    const Source* source;
    int left, columns;
    Integers column;     // of the pattern's image
    Words right;         // parts of a pixel more
    Floats start, down;  // its row at the picture's row 0, and how many more a row further
    Words colour;

    Part(const Picture& picture, const Run& run, const Source& what, int first, int end)
        : source(&what), left(first), columns(end - first) {
        const Solid& solid = picture.solids[run.solid];
        const CameraInFrame eye(solid, picture.pose);
        for (int i = 0; i < kBlock; ++i) {
            const int at = std::min(first + i, end - 1);
            const double slope = picture.camera.right[at], z = picture.visible.layers[run.layer].depth[at];
            if (what.tones)
                place(i, along(eye, solid, run.face, slope, z), z, picture);
            else
                colour[i] = what.curved ? shaded(solid, slope, z, picture) : what.colour;
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

    void place(int i, double metres, double z, const Picture& picture) {
        const double offset = source->pad - 0.5, last = (source->width - 1.0) * kPart - 1;
        double across = (metres * source->along + offset) * kPart;
        across = across > 0 ? across : 0;
        across = across < last ? across : last;
        const int whole = static_cast<int>(across + 0.5);
        column[i] = whole / kPart, right[i] = whole % kPart;
        const double each = z / picture.camera.focal * source->up;
        down[i] = static_cast<float>(each);
        start[i] = static_cast<float>((source->top - picture.pose.z) * source->up - picture.camera.cy * each + offset
                                      + 0.5 / kPart);
    }

    static Colour shaded(const Solid& solid, double slope, double z, const Picture& picture) {
        const Pose& pose = picture.pose;
        const double aside = z * slope;
        const double normal_x = (pose.x + z * pose.cos + aside * pose.sin - solid.x) / solid.radius;
        const double normal_y = (pose.y + z * pose.sin - aside * pose.cos - solid.y) / solid.radius;
        const double shade = picture.light.upright + picture.light.x * normal_x + picture.light.y * normal_y;
        Colour out = 0;
        for (int k = 0; k < 3; ++k) {
            const double value = std::min(std::max(std::nearbyint(solid.round[k] * shade), 0.0), 255.0);
            out |= static_cast<Colour>(value) << 8 * k;
        }
        return out;
    }

    ROBOTONT_INLINE Words draw(int row, const Response& response) const {
        if (!source->tones) return colour;
        const float last = static_cast<float>((source->height - 1) * kPart - 1);
        Floats place = (start + static_cast<float>(row) * down) * kPart;
        place = place > 0 ? place : 0;
        place = place < last ? place : last;
        const Integers whole = __builtin_convertvector(place, Integers);
        return blend_tones(*source, response, (whole >> 8) * source->width + column, right,
                           (Words)(whole & (kPart - 1)), source->tint);
    }
};

// The columns from `left` on, at most kBlock, of all rows.
class Block {
  public:
    Block(const Camera& camera, const Response& response)
        : camera_(camera), response_(response), colours_(camera.height * kBlock), cover_(camera.height) {}

    void begin(int left, const std::vector<Mask>& masks) {
        left_ = left, columns_ = std::min(kBlock, camera_.width - left);
        std::fill(cover_.begin(), cover_.end(), kNothing);
        for (int layer = 0; layer < static_cast<int>(masks.size()); ++layer) {
            const int *first = &masks[layer].first[left], *end = &masks[layer].end[left];
            const int from = *std::max_element(first, first + columns_), to = *std::min_element(end, end + columns_);
            for (int row = from; row < to; ++row) cover_[row] = std::min(cover_[row], layer);
        }
    }

    ROBOTONT_INLINE void draw_background(const Background& background, const std::vector<FloorRow>& floor) {
        for (int row = 0; row < camera_.height; ++row) {
            if (cover_[row] != kNothing) continue;
            Colour* out = &colours_[row * kBlock];
            if (floor[row].level == kPlain)
                std::fill(out, out + kBlock, background.rows[row]);
            else {
                const Words drawn = draw_floor(floor[row], background, left_, response_);
                std::memcpy(out, &drawn, sizeof drawn);
            }
        }
    }

    // Draws columns of a run of a layer, all of which are in this block.
    ROBOTONT_INLINE void draw(const Part& part, int layer, const Mask& mask) {
        int top = camera_.height, bottom = 0, first = 0, end = top;
        for (int i = part.left; i < part.left + part.columns; ++i) {
            first = std::max(first, mask.first[i]), end = std::min(end, mask.end[i]);
            top = std::min(top, static_cast<int>(std::floor(mask.upper[i] - 0.5 * mask.wide_upper[i])));
            bottom = std::max(bottom, static_cast<int>(std::ceil(mask.lower[i] + 0.5 * mask.wide_lower[i])) + 1);
        }
        for (int row = std::max(top, 0); row < std::min(bottom, camera_.height); ++row) {
            if (cover_[row] < layer) continue;
            Colour* out = &colours_[row * kBlock + part.left - left_];
            const Words drawn = part.draw(row, response_);
            if (row >= first && row < end && part.columns == kBlock)
                std::memcpy(out, &drawn, sizeof drawn);
            else
                for (int i = 0; i < part.columns; ++i) {
                    const int column = part.left + i;
                    const bool whole = row >= mask.first[column] && row < mask.end[column];
                    out[i] = whole ? drawn[i] : blended(out[i], drawn[i], mask.share(column, row), response_);
                }
        }
    }

    ROBOTONT_INLINE void write(bool bgr, std::uint8_t* pixels) const {
        for (int row = 0; row < camera_.height; ++row) {
            Words colours;
            std::memcpy(&colours, &colours_[row * kBlock], sizeof colours);
            if (bgr) colours = (colours & 0xff00) | colours >> 16 | (colours & 255) << 16;
            std::uint8_t* out = pixels + (row * camera_.width + left_) * 3;
            if (kLittleEndian && columns_ == kBlock) {
                Bytes bytes;
                std::memcpy(&bytes, &colours, sizeof bytes);
                bytes = __builtin_shuffle(bytes, kPacked);
                std::memcpy(out, &bytes, 12);
                std::memcpy(out + 12, reinterpret_cast<const std::uint8_t*>(&bytes) + 16, 12);
            } else
                for (int i = 0; i < 3 * columns_; ++i)
                    out[i] = static_cast<std::uint8_t>(colours[i / 3] >> 8 * (i % 3));
        }
    }

  private:
    const Camera& camera_;
    const Response& response_;
    int left_ = 0, columns_ = 0;
    std::vector<Colour> colours_;  // (height, kBlock)
    std::vector<int> cover_;       // (height,): the nearest layer that hides the rest
};

}  // namespace

ROBOTONT_FAST void draw_picture(const Picture& picture, bool bgr, std::uint8_t* pixels) {
    const Camera& camera = picture.camera;
    const Visible& visible = picture.visible;
    std::vector<Mask> masks;
    for (int layer = 0; layer < visible.count; ++layer) masks.emplace_back(visible.layers[layer], camera);
    const std::vector<FloorRow> floor = floor_rows(camera, picture.pose, picture.background);
    Block block(camera, picture.response);
    for (int left = 0; left < camera.width; left += kBlock) {
        block.begin(left, masks);
        block.draw_background(picture.background, floor);
        for (int k = static_cast<int>(visible.runs.size()) - 1; k >= 0; --k) {
            const Run& run = visible.runs[k];
            const int first = std::max(left, run.left), end = std::min(left + kBlock, run.right);
            if (first < end)
                block.draw(Part(picture, run, *picture.sources[k], first, end), run.layer, masks[run.layer]);
        }
        block.write(bgr, pixels);
    }
}

}  // namespace robotont
