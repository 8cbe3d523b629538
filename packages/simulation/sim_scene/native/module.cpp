// The module sim_scene._native; its names and types: src/sim_scene/_native.pyi.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <map>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

#include "scene.h"

namespace py = pybind11;
using namespace pybind11::literals;

namespace robotont {
namespace {

using Bytes = py::array_t<std::uint8_t, py::array::c_style>;
using Lights = py::array_t<std::uint16_t, py::array::c_style>;

void require(bool condition, const std::string& message) {
    if (!condition) throw std::invalid_argument(message);
}

// Rows (N,) of an array (N, 3) of colours, red, green, blue.
std::vector<Colour> packed(const Bytes& colours, const std::string& name, py::ssize_t count) {
    require(colours.ndim() == 2 && colours.shape(0) == count && colours.shape(1) == 3,
            name + " must be an array (" + std::to_string(count) + ", 3) of colours");
    std::vector<Colour> out;
    for (const std::uint8_t* c = colours.data(); out.size() < static_cast<std::size_t>(count); c += 3)
        out.push_back(c[0] | c[1] << 8 | c[2] << 16);
    return out;
}

// A colour, 0 to 255, in 1 / 65536.
std::array<std::uint32_t, 3> tint(const Rgb& colour) {
    std::array<std::uint32_t, 3> out;
    for (int k = 0; k < 3; ++k) {
        require(colour[k] >= 0.0 && colour[k] <= 255.0, "a colour must be 0 to 255");
        out[k] = static_cast<std::uint32_t>(std::nearbyint(colour[k] * (65536.0 / 255.0)));
    }
    return out;
}

Camera make_camera(int width, int height, double focal, double cx, double cy, double near) {
    require(width > 0 && height > 0 && focal > 0.0 && near > 0.0, "width, height, focal and near must be more than 0");
    return {width, height, focal, cx, cy, near};
}

Solid look(Solid solid, double rank, const Bytes& ends) {
    const std::vector<Colour> colours = packed(ends, "ends", 2);
    solid.rank = rank, solid.upper_end = colours[0], solid.lower_end = colours[1];
    return solid;
}

Solid make_box(double x, double y, double yaw, double length, double width, double bottom, double height, double rank,
               const Bytes& sides, const Bytes& ends, const std::array<double, 4>& resolution, int steps,
               double sharper) {
    require(steps > 0, "steps must be more than 0");
    Solid box = look(Solid::make_box(x, y, yaw, length, width, bottom, height), rank, ends);
    const std::vector<Colour> colours = packed(sides, "sides", 4);
    std::copy(colours.begin(), colours.end(), box.sides.begin());
    std::copy(resolution.begin(), resolution.end(), box.resolution.begin());
    box.levels = level_sizes(steps, sharper);
    return box;
}

Solid make_cylinder(double x, double y, double radius, double bottom, double height, double rank, const Rgb& colour,
                    const Bytes& ends) {
    Solid cylinder = look(Solid::make_cylinder(x, y, radius, bottom, height), rank, ends);
    cylinder.round = colour;
    return cylinder;
}

Response make_response(const std::array<std::uint16_t, Response::kValues>& light) {
    require(light[0] == 0 && light.back() == Response::kFull, "light must be 0 to " + std::to_string(Response::kFull));
    for (int value = 1; value < Response::kValues; ++value)
        require(light[value - 1] < light[value], "light must rise from each value to the next one");
    return Response(light);
}

// An image of tones, and the same in light
struct Image {
    Bytes tones;
    Lights light;
    Tones view() const {
        return {tones.data(), light.data(), static_cast<int>(tones.shape(1)), static_cast<int>(tones.shape(0))};
    }
};

Image make_image(const Bytes& tones, const Response& response) {
    require(tones.ndim() == 2 && tones.shape(0) > 1 && tones.shape(1) > 1, "tones must be an array of 2 x 2 or more");
    Image image = {tones, Lights({tones.shape(0), tones.shape(1)})};
    std::transform(tones.data(), tones.data() + tones.size(), image.light.mutable_data(),
                   [&](std::uint8_t tone) { return response.light[tone]; });
    return image;
}

struct Pattern {
    Source source;
    Image image;  // which `source` points to
};

Pattern make_pattern(const Image& image, double along, double up, double top, double pad, const Rgb& colour) {
    Pattern pattern = {{}, image};
    static_cast<Tones&>(pattern.source) = image.view();
    pattern.source.along = along, pattern.source.up = up, pattern.source.top = top, pattern.source.pad = pad;
    pattern.source.tint = tint(colour);
    return pattern;
}

struct Surroundings {
    Background background;
    std::vector<Image> floor;  // which `background` points to
};

Surroundings make_background(const Bytes& rows, const std::vector<Image>& floor, const Rgb& colour, double period,
                             double sharpness) {
    Surroundings out;
    out.floor = floor;
    out.background.rows = packed(rows, "rows", rows.ndim() ? rows.shape(0) : 0);
    out.background.tint = tint(colour), out.background.period = period, out.background.sharpness = sharpness;
    for (const Image& image : floor) {
        const Tones tones = image.view();
        int bits = 0;
        while (bits < 12 && (1 << bits) + 1 < tones.height) ++bits;
        require(tones.height == tones.width && tones.height == (1 << bits) + 1,
                "an image of the floor must be square, with 2**n + 1 pixels");
        out.background.floor.push_back({tones, bits});
    }
    return out;
}

// What one camera sees in one world; only one thread may use it at a time.
class Scene {
  public:
    Scene(const Camera& camera, std::vector<Solid> solids, const Surroundings& surroundings, const Light& light,
          const Response& response, py::function pattern)
        : camera_(camera), solids_(std::move(solids)), surroundings_(surroundings), light_(light),
          response_(response), pattern_(std::move(pattern)) {
        require(static_cast<int>(surroundings.background.rows.size()) == camera.height,
                "rows must have a colour for each row of the camera");
    }

    Bytes picture(const Pose& pose, bool bgr) {
        find(pose);
        std::vector<const Source*> sources;
        for (const Run& run : visible_.runs) sources.push_back(source(run));
        Bytes pixels({camera_.height, camera_.width, 3});
        std::uint8_t* out = pixels.mutable_data();
        const py::gil_scoped_release others_may_run;
        draw_picture({camera_, pose, solids_, visible_, sources, surroundings_.background, light_, response_}, bgr,
                     out);
        return pixels;
    }

    py::array_t<float> depth(const Pose& pose, double near, double far) {
        find(pose);
        py::array_t<float> depths({camera_.height, camera_.width});
        float* out = depths.mutable_data();
        const py::gil_scoped_release others_may_run;
        draw_depth(camera_, pose, solids_, visible_, near, far, out);
        return depths;
    }

  private:
    void find(const Pose& pose) {
        if (found_ && pose == pose_) return;
        found_ = false;
        const py::gil_scoped_release others_may_run;
        find_visible(camera_, pose, solids_, &visible_);
        pose_ = pose, found_ = true;
    }

    const Source* source(const Run& run) {
        const auto key = std::make_tuple(run.solid, run.kind, run.face, run.along, run.up);
        auto found = patterns_.find(key);
        if (found == patterns_.end()) found = patterns_.emplace(key, new_pattern(run)).first;
        return &found->second.source;
    }

    Pattern new_pattern(const Run& run) const {
        const Solid& solid = solids_[run.solid];
        if (run.kind == kFront && !std::isnan(solid.resolution[run.face]))
            return pattern_("solid"_a = run.solid, "face"_a = run.face, "along"_a = run.along, "up"_a = run.up)
                .cast<Pattern>();
        Pattern plain = {};
        plain.source.curved = run.kind == kFront && run.face == kRound;
        plain.source.colour = run.kind == kFront ? solid.sides[run.face]
                              : run.kind == kTop ? solid.upper_end : solid.lower_end;
        return plain;
    }

    const Camera camera_;
    const std::vector<Solid> solids_;
    const Surroundings surroundings_;
    const Light light_;
    const Response response_;
    const py::function pattern_;
    std::map<std::tuple<int, int, int, int, int>, Pattern> patterns_;  // by solid, kind, face and levels
    bool found_ = false;
    Pose pose_ = {0.0, 0.0, 0.0, 0.0};
    Visible visible_;  // from pose_
};

}  // namespace
}  // namespace robotont

PYBIND11_MODULE(_native, module) {
    using namespace robotont;
    module.doc() = "The compiled steps of the renderer; see _native.pyi";
    py::class_<Camera>(module, "Camera")
        .def(py::init(&make_camera), py::kw_only(), "width"_a, "height"_a, "focal"_a, "cx"_a, "cy"_a, "near"_a);
    py::class_<Pose>(module, "Pose")
        .def(py::init<double, double, double, double>(), "x"_a, "y"_a, "z"_a, "yaw"_a);
    py::class_<Solid>(module, "Solid")
        .def_static("box", &make_box, py::kw_only(), "x"_a, "y"_a, "yaw"_a, "length"_a, "width"_a, "bottom"_a,
                    "height"_a, "rank"_a, "sides"_a, "ends"_a, "resolution"_a, "steps"_a, "sharper"_a)
        .def_static("cylinder", &make_cylinder, py::kw_only(), "x"_a, "y"_a, "radius"_a, "bottom"_a, "height"_a,
                    "rank"_a, "colour"_a, "ends"_a);
    py::class_<Response>(module, "Response")
        .def(py::init(&make_response), py::kw_only(), "light"_a);
    py::class_<Image>(module, "Image")
        .def(py::init(&make_image), py::kw_only(), "tones"_a, "response"_a);
    py::class_<Pattern>(module, "Pattern")
        .def(py::init(&make_pattern), py::kw_only(), "image"_a, "along"_a, "up"_a, "top"_a, "pad"_a, "colour"_a);
    py::class_<Surroundings>(module, "Background")
        .def(py::init(&make_background), py::kw_only(), "rows"_a, "floor"_a, "colour"_a, "period"_a, "sharpness"_a);
    py::class_<Light>(module, "Light")
        .def(py::init([](double upright, double x, double y) { return Light{upright, x, y}; }), py::kw_only(),
             "upright"_a, "x"_a, "y"_a);
    py::class_<Scene>(module, "Scene")
        .def(py::init<const Camera&, std::vector<Solid>, const Surroundings&, const Light&, const Response&,
                      py::function>(),
             py::kw_only(), "camera"_a, "solids"_a, "background"_a, "light"_a, "response"_a, "pattern"_a)
        .def("picture", &Scene::picture, "pose"_a, py::kw_only(), "bgr"_a)
        .def("depth", &Scene::depth, "pose"_a, py::kw_only(), "near"_a, "far"_a);
}
