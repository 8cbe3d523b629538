// The Python module with all steps: alvar_core._native, and _native_avx2 for processors that have AVX2 and FMA.
// Arrays are checked here, so that no step reads beyond one. Long steps release Python's lock (GIL).
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cstring>

#include "algebra.h"
#include "curved.h"
#include "steps.h"

// pybind11 before 2.6, as Ubuntu 20.04 has it, cannot ask for keywords; it takes them.
#if PYBIND11_VERSION_MAJOR == 2 && PYBIND11_VERSION_MINOR < 6
namespace pybind11 {
struct kw_only {};
namespace detail {
template <>
struct process_attribute<kw_only> : process_attribute_default<kw_only> {};
}  // namespace detail
}  // namespace pybind11
#endif

namespace py = pybind11;
using namespace py::literals;
using namespace alvar;

namespace {

template <typename Number>
using Array = py::array_t<Number, py::array::c_style | py::array::forcecast>;
using Doubles = Array<double>;
using Floats = Array<float>;
using Integers = Array<std::int64_t>;
using Bytes = Array<std::uint8_t>;
using Unlocked = py::gil_scoped_release;

constexpr py::ssize_t kAny = -1;

// Raises ValueError unless an array has this shape.
void check(const py::array& array, std::initializer_list<py::ssize_t> shape, const char* name) {
    bool same = array.ndim() == py::ssize_t(shape.size());
    py::ssize_t axis = 0;
    for (const py::ssize_t length : shape) {
        same = same && (length == kAny || array.shape(axis) == length);
        ++axis;
    }
    if (same) return;
    py::list wanted;
    for (const py::ssize_t length : shape) wanted.append(length == kAny ? py::object(py::str("any")) : py::cast(length));
    throw py::value_error(std::string(name) + " has the shape " + std::string(py::str(py::tuple(array.attr("shape"))))
                          + ", but " + std::string(py::str(py::tuple(wanted))) + " is needed");
}

Image image_of(const py::array_t<std::uint8_t>& grey) {
    if (grey.ndim() != 2 || grey.shape(0) < 2 || grey.shape(1) < 2 || grey.strides(1) != 1)
        throw py::value_error("an image needs rows of uint8 greys, at least 2 x 2");
    return {grey.data(), grey.strides(0), int(grey.shape(1)), int(grey.shape(0))};
}

Pyramid pyramid_of(const py::array_t<std::uint8_t>& atlas, const Floats& table) {
    static_assert(sizeof(Level) == 7 * sizeof(float), "a row of the table");
    check(table, {3, 7}, "table");
    return {image_of(atlas), reinterpret_cast<const Level*>(table.data())};
}

// `ask`: markers give evidence about the light
Measured measured_of(const py::array_t<std::uint8_t>& atlas, const Floats& table, const py::array_t<std::uint8_t>& full,
                     const Light& light, bool ask) {
    const Pyramid greys = pyramid_of(atlas, table);
    return {{greys.atlas.lit(light.table()), greys.levels}, image_of(full).lit(light.table()), ask ? &light : nullptr};
}

Turn turn_of(std::int64_t most, std::int64_t first) {
    if (most < 1 || first < 0) throw py::value_error("at least one candidate has a turn, and the first is 0 or above");
    return {most, first};
}

void check_levels(const Integers& levels, py::ssize_t count) {
    check(levels, {count}, "level");
    for (py::ssize_t m = 0; m < count; ++m)
        if (levels.data()[m] < 0 || levels.data()[m] > 2) throw py::value_error("a level is 0, 1 or 2");
}

template <typename Number>
std::vector<Number> vector_of(const Array<Number>& array) {
    return std::vector<Number>(array.data(), array.data() + array.size());
}

// An array of one axis. pybind11's array_t(count) is not used: in some versions, its stride is 0.
template <typename Number>
Array<Number> line_of(py::ssize_t count) {
    return Array<Number>(std::vector<py::ssize_t>{count});
}

template <typename Number>
py::array_t<Number> array_of(const std::vector<Number>& numbers, std::vector<py::ssize_t> shape) {
    py::array_t<Number> array(std::move(shape));
    std::copy(numbers.begin(), numbers.end(), array.mutable_data());
    return array;
}

template <typename Row>
py::array_t<Row> array_of(const std::vector<Row>& rows) {
    return array_of(rows, {py::ssize_t(rows.size())});
}

template <typename Number>
Array<Number> copy_of(const Array<Number>& array) {
    Array<Number> copy(std::vector<py::ssize_t>(array.shape(), array.shape() + array.ndim()));
    std::copy_n(array.data(), array.size(), copy.mutable_data());
    return copy;
}

// The first `count` of the rows of an array (N, ...)
py::object first_rows(const py::array& array, int count) { return array[py::slice(0, count, 1)]; }

Requirement requirement_of(const py::handle& value) {
    return {value.attr("fit").cast<double>(), value.attr("margin_ratio").cast<double>(),
            value.attr("correlation").cast<double>()};
}

Range range_of(const py::handle& value) {
    const auto both = value.cast<std::pair<double, double>>();
    return {both.first, both.second};
}

void read_thresholds(Thresholds& limit, const py::handle& module) {
#define ALVAR_READ_NUMBER(name) limit.name = module.attr(#name).cast<double>();
#define ALVAR_READ_RANGE(name) limit.name = range_of(module.attr(#name));
#define ALVAR_READ_REQUIREMENT(name) limit.name = requirement_of(module.attr(#name));
    ALVAR_NUMBERS(ALVAR_READ_NUMBER)
    ALVAR_RANGES(ALVAR_READ_RANGE)
    ALVAR_REQUIREMENTS(ALVAR_READ_REQUIREMENT)
}

// Of an Alignment of `markers` markers: arrays as in alignment.py, and one AlignedMarker for each
struct Alignment {
    Doubles h, blur, contrast, noise, moved, normal;
    Integers level;
    Bytes black;
    Floats values, drawing, model, gain, dark, weights;

    std::vector<AlignedMarker> markers(int samples, int cells) {
        const py::ssize_t count = h.shape(0), black_cells = py::ssize_t(cells) * cells;
        check(h, {count, 3, 3}, "h"), check(blur, {count}, "blur"), check_levels(level, count);
        check(black, {count, cells, cells}, "black"), check(contrast, {count}, "contrast");
        check(noise, {count}, "noise"), check(moved, {count}, "moved");
        check(normal, {count, kParameters, kParameters}, "normal");
        for (const Floats* each : {&values, &drawing, &model, &gain, &dark, &weights})
            check(*each, {count, samples}, "values, template, model, gain, dark or weights");
        std::vector<AlignedMarker> out;
        for (py::ssize_t m = 0; m < count; ++m) {
            const auto of = [&](Floats& all) { return const_cast<float*>(all.data()) + m * samples; };
            const auto at = [&](Doubles& all, int each) { return const_cast<double*>(all.data()) + m * each; };
            out.push_back({at(h, 9), at(blur, 1), level.data()[m], black.data() + m * black_cells, of(values),
                           of(drawing), of(model), of(gain), of(dark), of(weights), at(contrast, 1), at(noise, 1),
                           at(moved, 1), at(normal, kParameters * kParameters)});
        }
        return out;
    }
};

// The fields of an Alignment of alignment.py; `black` is not one of them.
Alignment alignment_of(const py::object& state, const Bytes& black) {
    return {state.attr("h").cast<Doubles>(),         state.attr("blur").cast<Doubles>(),
            state.attr("contrast").cast<Doubles>(),  state.attr("noise").cast<Doubles>(),
            state.attr("moved").cast<Doubles>(),     state.attr("normal").cast<Doubles>(),
            state.attr("level").cast<Integers>(),    black,
            state.attr("values").cast<Floats>(),     state.attr("template").cast<Floats>(),
            state.attr("model").cast<Floats>(),      state.attr("gain").cast<Floats>(),
            state.attr("dark").cast<Floats>(),       state.attr("weights").cast<Floats>()};
}

py::dict align(const Aligner& self, const py::array_t<std::uint8_t>& atlas, const Floats& table, const Lens& lens,
               const Doubles& h, const Bytes& black, const Doubles& blur, const Integers& level, int steps,
               const std::vector<int>& redraw, const Thresholds& limit) {
    const py::ssize_t count = h.shape(0), samples = py::ssize_t(self.count) * self.count;
    const auto floats = [&] { return Floats({count, samples}); };
    Alignment state = {copy_of(h), copy_of(blur), line_of<double>(count), line_of<double>(count),
                       line_of<double>(count),
                       Doubles({count, py::ssize_t(kParameters), py::ssize_t(kParameters)}), level, black,
                       floats(), floats(), floats(), floats(), floats(), floats()};
    std::vector<AlignedMarker> markers = state.markers(samples, self.cells);
    const Pyramid pyramid = pyramid_of(atlas, table);
    unsigned bits = 0;
    for (const int step : redraw) bits |= 1u << step;
    {
        Unlocked unlocked;
        self.run(pyramid, lens, markers, steps, bits, limit);
    }
    return py::dict("h"_a = state.h, "blur"_a = state.blur, "level"_a = level, "values"_a = state.values,
                    "template"_a = state.drawing, "model"_a = state.model, "gain"_a = state.gain, "dark"_a = state.dark,
                    "contrast"_a = state.contrast, "weights"_a = state.weights, "noise"_a = state.noise,
                    "normal"_a = state.normal, "moved"_a = state.moved);
}

py::array_t<float> sample(const Aligner& self, const py::array_t<std::uint8_t>& atlas, const Floats& table,
                          const Lens& lens, const Doubles& h, const Integers& level) {
    const py::ssize_t count = h.shape(0), samples = py::ssize_t(self.count) * self.count;
    check(h, {count, 3, 3}, "h"), check_levels(level, count);
    py::array_t<float> values({count, samples});
    for (py::ssize_t m = 0; m < count; ++m)
        self.sample(pyramid_of(atlas, table), lens, h.data() + 9 * m, level.data()[m], values.mutable_data() + samples * m);
    return values;
}

Features features_of(double likeness, double outside, double correlation, std::int64_t bad_inside, std::int64_t bad_rim,
                     double inlier_share, double contrast, double noise, double blur, double fit, double score_gap,
                     std::int64_t edges, double outside_but_one) {
    return {likeness, outside, correlation, bad_inside, bad_rim, inlier_share, contrast, noise, blur, fit, score_gap,
            edges, outside_but_one};
}

py::object shortfall_of(const Shortfall& found) {
    if (!found.threshold) return py::none();
    return py::make_tuple(found.threshold, found.value, found.needed);
}

// Appends where candidates ended to a list of Python, or nothing to None: (quad (4, 2), threshold, value, needed, word)
void extend(const py::object& ended, const Trail& trail) {
    if (ended.is_none()) return;
    for (const Ended& each : trail) {
        const std::vector<double> quad(each.quad, each.quad + 8);
        ended.attr("append")(py::make_tuple(array_of(quad, {py::ssize_t(4), py::ssize_t(2)}), each.missed.threshold,
                                            each.missed.value, each.missed.needed, each.word));
    }
}

EdgePoints edge_points_of(const Doubles& middle, const Doubles& outward) {
    const py::ssize_t count = middle.shape(0);
    check(middle, {count, 2}, "middle"), check(outward, {count, 2}, "outward");
    EdgePoints points;
    for (py::ssize_t i = 0; i < count; ++i) {
        points.x.push_back(middle.at(i, 0)), points.y.push_back(middle.at(i, 1));
        points.right.push_back(outward.at(i, 0)), points.down.push_back(outward.at(i, 1));
    }
    return points;
}

// The fields of edge_alignment.EdgeFit; None if too few edges were seen
py::object dict_of(const EdgeFit& fit, int parameters, int free) {
    if (!fit.seen_enough) return py::none();
    py::array_t<bool> agrees = line_of<bool>(fit.agrees.size());
    std::copy(fit.agrees.begin(), fit.agrees.end(), agrees.mutable_data());
    const std::vector<double> theta(fit.parameters, fit.parameters + parameters);
    const std::vector<double> covariance(fit.covariance, fit.covariance + free * free);
    return py::dict("parameters"_a = array_of(theta), "covariance"_a = array_of(covariance, {free, free}),
                    "error"_a = fit.error, "agrees"_a = agrees, "cost"_a = fit.cost);
}

}  // namespace

#ifndef ALVAR_MODULE
#define ALVAR_MODULE _native
#endif

PYBIND11_MODULE(ALVAR_MODULE, m) {
    m.doc() = "The compiled steps of the detector; native/steps.h says what each takes.";
    PYBIND11_NUMPY_DTYPE(Features, likeness, outside, correlation, bad_inside, bad_rim, inlier_share, contrast,
                         noise, blur, fit, score_gap,
                         edges, outside_but_one);
    PYBIND11_NUMPY_DTYPE(Solution, rotation, position, error, chi2);
    PYBIND11_NUMPY_DTYPE(ResponseEvidence, information, weighted);
    PYBIND11_NUMPY_DTYPE(FoundMarker, number, corners, information, poses, solutions, features, evidence);
    PYBIND11_NUMPY_DTYPE(Start, h, blur, level, word, fit, score_gap);
    PYBIND11_NUMPY_DTYPE(WellRead, quad, word);
    PYBIND11_NUMPY_DTYPE(LocalMatch, rim, contrast, plain, fit, score_gap, word);

    py::class_<Thresholds>(m, "Thresholds")
        .def(py::init([](const py::object& module) {
                 Thresholds limit;
                 read_thresholds(limit, module);
                 return limit;
             }),
             "module"_a)
        .def("read", &read_thresholds, "module"_a, "Read all thresholds again, which have changed.");

    py::class_<Lens>(m, "Lens")
        .def(py::init([](double fx, double fy, double cx, double cy, double k1, double k2, double p1, double p2, double k3,
                         double k4, double k5, double k6, bool fisheye) {
                 return Lens{fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6, fisheye};
             }),
             py::kw_only(), "fx"_a, "fy"_a, "cx"_a, "cy"_a, "k1"_a, "k2"_a, "p1"_a = 0, "p2"_a = 0, "k3"_a, "k4"_a,
             "k5"_a = 0, "k6"_a = 0, "fisheye"_a = false);

    py::class_<Light>(m, "Light")
        .def(py::init<double>(), py::kw_only(), "gamma"_a)
        .def_property_readonly("of_grey", [](const Light& self) {
            return array_of(std::vector<float>(self.of_grey, self.of_grey + kGreys));
        })
        .def(
            "halve",
            [](const Light& self, const py::array_t<std::uint8_t>& grey, py::array_t<std::uint8_t> out) {
                const Image image = image_of(grey), half = image_of(out);
                if (half.width != image.width / 2 || half.height != image.height / 2)
                    throw py::value_error("out is not half of grey");
                halve(image, self, out.mutable_data(), half.stride);
            },
            py::kw_only(), "grey"_a, "out"_a);

    m.def("noise_of", [](const py::array_t<std::uint8_t>& grey) { return noise_of(image_of(grey)); }, "grey"_a);

    m.def(
        "outlines",
        [](const py::array_t<std::uint8_t>& smooth, const py::array_t<std::uint8_t>& mean, int offset, double shrink,
           bool parted, const Thresholds& limit) {
            const Image grey = image_of(smooth), around = image_of(mean);
            if (grey.width != around.width || grey.height != around.height)
                throw py::value_error("smooth and mean differ in size");
            Outlines found;
            {
                Unlocked unlocked;
                found = outlines_of(grey, around, offset, shrink, parted, limit);
            }
            return py::make_tuple(array_of(found.quads, {py::ssize_t(found.quads.size()) / 8, 4, 2}),
                                  array_of(found.parts, {py::ssize_t(found.parts.size()) / 4, 2, 2}));
        },
        py::kw_only(), "smooth"_a, "mean"_a, "offset"_a, "shrink"_a, "parted"_a, "limit"_a);

    m.def(
        "small_squares",
        [](const py::array_t<std::uint8_t>& smooth, const Doubles& quads, const Thresholds& limit) {
            check(quads, {kAny, 4, 2}, "quads");
            std::vector<double> found;
            const Image image = image_of(smooth);
            {
                Unlocked unlocked;
                found = small_squares(image, quads.shape(0), quads.data(), limit);
            }
            return array_of(found, {py::ssize_t(found.size()) / 8, 4, 2});
        },
        py::kw_only(), "smooth"_a, "quads"_a, "limit"_a);

    m.def(
        "refined",
        [](const py::array_t<std::uint8_t>& smooth, const Doubles& quads, const Thresholds& limit, const py::object& ended) {
            check(quads, {kAny, 4, 2}, "quads");
            Doubles out = copy_of(quads);
            Trail trail;
            const int kept = refine_sides(image_of(smooth), out.shape(0), out.mutable_data(), limit, &trail);
            extend(ended, trail);
            return first_rows(out, kept);
        },
        py::kw_only(), "smooth"_a, "quads"_a, "limit"_a, "ended"_a = py::none());

    m.def(
        "distinct",
        [](const Doubles& quads, const Doubles& score, const std::vector<int>& which, const Thresholds& limit) {
            check(quads, {kAny, 4, 2}, "quads"), check(score, {quads.shape(0)}, "score");
            for (const int each : which)
                if (each < 0 || each >= quads.shape(0)) throw py::index_error("no quad has this index");
            return distinct(quads.data(), score.data(), which, limit);
        },
        py::kw_only(), "quads"_a, "score"_a, "which"_a, "limit"_a);

    m.def(
        "in_turn",
        [](const Doubles& quads, const std::vector<int>& which, std::int64_t most, std::int64_t first) {
            check(quads, {kAny, 4, 2}, "quads");
            for (const int each : which)
                if (each < 0 || each >= quads.shape(0)) throw py::index_error("no quad has this index");
            return in_turn(quads.data(), which, turn_of(most, first));
        },
        py::kw_only(), "quads"_a, "which"_a, "most"_a, "first"_a);

    m.def(
        "free_of",
        [](const Doubles& squares, const Doubles& points) {
            check(squares, {kAny, 3}, "squares"), check(points, {kAny, 2}, "points");
            const auto free = free_of(vector_of(squares), points.shape(0), points.data());
            auto out = line_of<bool>(free.size());
            std::copy(free.begin(), free.end(), out.mutable_data());
            return out;
        },
        py::kw_only(), "squares"_a, "points"_a);

    m.def(
        "distinct_parts",
        [](const py::array_t<std::uint8_t>& smooth, const Doubles& parts, const Thresholds& limit) {
            check(parts, {kAny, 2, 2}, "parts");
            Doubles out = copy_of(parts);
            return first_rows(out, distinct_parts(image_of(smooth), out.shape(0), out.mutable_data(), limit));
        },
        py::kw_only(), "smooth"_a, "parts"_a, "limit"_a);

    m.def(
        "squares",
        [](const Doubles& parts, const Thresholds& limit) {
            check(parts, {kAny, 2, 2}, "parts");
            std::vector<double> quads;
            {
                Unlocked unlocked;
                quads = squares(parts.shape(0), parts.data(), limit);
            }
            return array_of(quads, {py::ssize_t(quads.size()) / 8, 4, 2});
        },
        py::kw_only(), "parts"_a, "limit"_a);

    m.def(
        "from_square",
        [](const Doubles& quads, double half) {
            check(quads, {kAny, 4, 2}, "quads");
            py::array_t<double> out({quads.shape(0), py::ssize_t(3), py::ssize_t(3)});
            for (py::ssize_t i = 0; i < quads.shape(0); ++i)
                from_square(quads.data() + 8 * i, half, out.mutable_data() + 9 * i);
            return out;
        },
        "quads"_a, "half"_a);

    py::class_<CoarseDecoder>(m, "CoarseDecoder")
        .def(py::init([](double half, const Floats& rim, const Floats& cells, const Floats& words,
                         const Floats& blurred, const Floats& known) {
                 const py::ssize_t points = cells.shape(1), all = words.shape(1);
                 check(rim, {3, 40}, "rim"), check(cells, {3, points}, "cells"), check(words, {points, all}, "words");
                 check(known, {known.shape(0) == 1 ? 1 : all, points}, "known");
                 check(blurred, {points, blurred.shape(1) ? all : 0}, "blurred");
                 return CoarseDecoder{half, int(points), int(all), vector_of(rim), vector_of(cells), vector_of(words),
                                      vector_of(blurred), vector_of(known)};
             }),
             py::kw_only(), "half"_a, "rim"_a, "cells"_a, "words"_a, "blurred"_a, "known"_a)
        .def(
            "match",
            [](const CoarseDecoder& self, const py::array_t<std::uint8_t>& smooth, const Doubles& quads,
               const Thresholds& limit, const py::object& ended) {
                check(quads, {kAny, 4, 2}, "quads");
                Trail trail;
                const CoarseMatch found = self.match(image_of(smooth), quads.shape(0), quads.data(), limit, &trail);
                extend(ended, trail);
                return py::dict("kept"_a = array_of(found.kept),
                                "h"_a = array_of(found.h, {py::ssize_t(found.kept.size()), 3, 3}),
                                "fit"_a = array_of(found.fit), "score_gap"_a = array_of(found.score_gap),
                                "word"_a = array_of(found.word));
            },
            py::kw_only(), "smooth"_a, "quads"_a, "limit"_a, "ended"_a = py::none())
        .def(
            "other_margin",
            [](const CoarseDecoder& self, const py::array_t<std::uint8_t>& smooth, const Doubles& corners) {
                check(corners, {4, 2}, "corners");
                return shortfall_of(self.other_margin(image_of(smooth), corners.data()));
            },
            py::kw_only(), "smooth"_a, "corners"_a);

    m.def(
        "coverage",
        [](const Floats& line, int cells, const Doubles& variance) {
            const py::ssize_t markers = variance.size(), count = line.size();
            py::array_t<float> out({markers, count, py::ssize_t(cells)});
            for (py::ssize_t k = 0; k < markers; ++k)
                coverage(line.data(), count, cells, variance.data()[k], out.mutable_data() + k * count * cells);
            return out;
        },
        py::kw_only(), "line"_a, "cells"_a, "variance"_a);

    py::class_<Reader>(m, "Reader")
        .def(py::init([](const Floats& line, const Floats& light, const Floats& words) {
                 const py::ssize_t side = line.size();
                 check(light, {side * side, 4}, "light"), check(words, {25, kAny}, "words");
                 return Reader{int(side), int(words.shape(1)), vector_of(line), vector_of(light), vector_of(words)};
             }),
             py::kw_only(), "line"_a, "light"_a, "words"_a)
        .def(
            "read",
            [](const Reader& self, const Floats& values, double xx, double yy, double noise, const Thresholds& limit) {
                check(values, {self.side, self.side}, "values");
                const Reader::Read found = self.read(values.data(), xx, yy, noise, limit);
                return py::make_tuple(found.word, found.fit, found.score_gap);
            },
            py::kw_only(), "values"_a, "xx"_a, "yy"_a, "noise"_a, "limit"_a);

    py::class_<Aligner>(m, "Aligner")
        .def(py::init([](int cells, const Floats& line, const Floats& weight) {
                 const py::ssize_t count = line.size();
                 check(weight, {count * count}, "weight");
                 if (cells < 1 || cells > kMostCells)
                     throw py::value_error("a marker has up to " + std::to_string(kMostCells) + " cells per side");
                 return Aligner{cells, int(count), vector_of(line), vector_of(weight)};
             }),
             py::kw_only(), "cells"_a, "line"_a, "weight"_a)
        .def("run", &align, py::kw_only(), "atlas"_a, "table"_a, "lens"_a, "h"_a, "black"_a, "blur"_a, "level"_a,
             "steps"_a, "redraw"_a, "limit"_a)
        .def("sample", &sample, py::kw_only(), "atlas"_a, "table"_a, "lens"_a, "h"_a, "level"_a);

    py::class_<Features>(m, "Features")
        .def(py::init(&features_of), py::kw_only(), "likeness"_a, "outside"_a, "correlation"_a, "bad_inside"_a,
             "bad_rim"_a, "inlier_share"_a, "contrast"_a, "noise"_a, "blur"_a, "fit"_a, "score_gap"_a, "edges"_a,
             "outside_but_one"_a);
    m.def("shortfall", [](const Features& f, const Thresholds& limit) { return shortfall_of(shortfall(f, limit)); },
          py::kw_only(), "features"_a, "limit"_a);
    m.def("may_be_covered", &may_be_covered, py::kw_only(), "features"_a, "limit"_a);
    m.def("is_sure", &is_sure, py::kw_only(), "features"_a, "limit"_a);
    m.def(
        "unpromising",
        [](const Doubles& h, double blur, std::int64_t level, double likeness, int cells, const Thresholds& limit) {
            check(h, {3, 3}, "h");
            return shortfall_of(unpromising(h.data(), blur, level, likeness, cells, limit));
        },
        py::kw_only(), "h"_a, "blur"_a, "level"_a, "likeness"_a, "cells"_a, "limit"_a);

    py::class_<Appearance>(m, "Appearance")
        .def(py::init([](int cells, double weight, const Floats& share, const Floats& smooth, const Integers& data,
                         const Array<std::int32_t>& group, const Bytes& is_data) {
                 check(smooth, {data.size(), 6}, "smooth"), check(group, {share.size()}, "group");
                 check(is_data, {py::ssize_t(cells) * cells}, "is_data");
                 for (py::ssize_t i = 0; i < data.size(); ++i)
                     if (data.data()[i] < 0 || data.data()[i] >= share.size())
                         throw py::index_error("data: no sample has this index");
                 for (py::ssize_t i = 0; i < group.size(); ++i)
                     if (group.data()[i] >= cells * cells + 4) throw py::index_error("group: no cell has this index");
                 return Appearance{cells, weight, vector_of(share), vector_of(smooth), vector_of(data), vector_of(group),
                                   vector_of(is_data)};
             }),
             py::kw_only(), "cells"_a, "weight"_a, "share"_a, "smooth"_a, "data"_a, "group"_a, "is_data"_a)
        .def(
            "features",
            [](const Appearance& self, const py::object& state, const Doubles& noise, const Thresholds& limit) {
                const Bytes black({noise.size(), py::ssize_t(self.cells), py::ssize_t(self.cells)});  // unused
                Alignment all = alignment_of(state, black);
                check(noise, {all.h.shape(0)}, "noise");
                std::vector<Features> found;
                int m = 0;
                for (const AlignedMarker& marker : all.markers(self.share.size(), self.cells))
                    found.push_back(self.features(marker, noise.data()[m++], limit));
                return array_of(found);
            },
            py::kw_only(), "state"_a, "noise"_a, "limit"_a);

    m.def(
        "edge_points",
        [](const Bytes& black, const std::vector<double>& places) {
            check(black, {kAny, black.shape(0)}, "black");
            const EdgePoints points = edge_points(black.data(), black.shape(0), places);
            const py::ssize_t count = points.x.size();
            py::array_t<double> middle({count, py::ssize_t(2)}), outward({count, py::ssize_t(2)});
            for (py::ssize_t i = 0; i < count; ++i) {
                middle.mutable_at(i, 0) = points.x[i], middle.mutable_at(i, 1) = points.y[i];
                outward.mutable_at(i, 0) = points.right[i], outward.mutable_at(i, 1) = points.down[i];
            }
            return py::make_tuple(middle, outward);
        },
        py::kw_only(), "black"_a, "places"_a);

    m.def(
        "fit_plane",
        [](const py::array_t<std::uint8_t>& grey, const Lens& lens, const Doubles& h, const Doubles& middle,
           const Doubles& outward, const Doubles& scale, double reach, double first_reach, int steps,
           const Light& light, const Thresholds& limit) -> py::object {
            check(h, {3, 3}, "h"), check(scale, {8}, "scale");
            const Image image = image_of(grey).lit(light.table());
            const EdgePoints points = edge_points_of(middle, outward);
            EdgeFit fit;
            {
                Unlocked unlocked;
                fit = fit_edges(image, lens, h.data(), points, scale.data(), reach, first_reach, steps, limit);
            }
            return dict_of(fit, 8, 8);
        },
        py::kw_only(), "grey"_a, "lens"_a, "h"_a, "middle"_a, "outward"_a, "scale"_a, "reach"_a, "first_reach"_a,
        "steps"_a, "light"_a, "limit"_a);

    m.def(
        "fit_curved",
        [](const py::array_t<std::uint8_t>& grey, const Lens& lens, int cells, const Doubles& starts,
           const Doubles& middle, const Doubles& outward, const Doubles& scale, double reach, double first_reach,
           int steps, const Light& light, const Thresholds& limit) {
            const int parameters = starts.ndim() == 2 && starts.shape(1) == 9 ? 9 : 8;
            check(starts, {kAny, parameters}, "starts"), check(scale, {kAny}, "scale");
            const int free = scale.shape(0);
            if (free < 1 || free > parameters) throw py::value_error("scale has more numbers than a start");
            const Image image = image_of(grey).lit(light.table());
            const EdgePoints points = edge_points_of(middle, outward);
            std::vector<EdgeFit> fits(starts.shape(0));
            {
                Unlocked unlocked;
                for (std::size_t k = 0; k < fits.size(); ++k)
                    fits[k] = fit_curved(image, lens, cells, starts.data() + k * parameters, parameters, free, points,
                                         scale.data(), reach, first_reach, steps, limit);
            }
            py::list out;
            for (const EdgeFit& fit : fits) out.append(dict_of(fit, parameters, free));
            return out;
        },
        py::kw_only(), "grey"_a, "lens"_a, "cells"_a, "starts"_a, "middle"_a, "outward"_a, "scale"_a, "reach"_a,
        "first_reach"_a, "steps"_a, "light"_a, "limit"_a);

    m.def(
        "curved_places",
        [](const Lens& lens, int cells, const Doubles& theta, const Doubles& points) {
            const int parameters = theta.size() == 9 ? 9 : 8;
            const py::ssize_t count = points.shape(0);
            check(theta, {parameters}, "theta"), check(points, {count, 2}, "points");
            Curved model(lens, cells, parameters);
            model.set(theta.data());
            std::vector<double> places(2 * count);
            for (py::ssize_t i = 0; i < count; ++i) model.place(points.at(i, 0), points.at(i, 1), &places[2 * i]);
            return array_of(places, {count, 2});
        },
        py::kw_only(), "lens"_a, "cells"_a, "theta"_a, "points"_a);

    m.def(
        "refine_edges",
        [](const py::array_t<std::uint8_t>& grey, const Lens& lens, const Doubles& h, double half, const Doubles& sigma,
           const Light& light, const Thresholds& limit) {
            const py::ssize_t count = h.shape(0);
            check(h, {count, 3, 3}, "h"), check(sigma, {count}, "sigma");
            const py::ssize_t two = 2, four = 4, eight = 8;
            py::array_t<double> corners({count, four, two}), covariance({count, eight, eight});
            py::array_t<bool> good = line_of<bool>(count);
            for (py::ssize_t m = 0; m < count; ++m)
                good.mutable_at(m) = refine_edges(image_of(grey).lit(light.table()), lens, h.data() + 9 * m, half,
                                                  sigma.at(m), limit, corners.mutable_data() + 8 * m,
                                                  covariance.mutable_data() + 64 * m);
            return py::make_tuple(corners, covariance, good);
        },
        py::kw_only(), "grey"_a, "lens"_a, "h"_a, "half"_a, "sigma"_a, "light"_a, "limit"_a);

    m.def(
        "bows",
        [](const py::array_t<std::uint8_t>& grey, const Lens& lens, const Doubles& corners, int cells,
           const Light& light, const Thresholds& limit) {
            check(corners, {kAny, 4, 2}, "corners");
            py::array_t<double> bows = line_of<double>(corners.shape(0));
            for (py::ssize_t m = 0; m < corners.shape(0); ++m)
                bows.mutable_at(m) = bow(image_of(grey).lit(light.table()), lens, corners.data() + 8 * m, cells, limit);
            return bows;
        },
        py::kw_only(), "grey"_a, "lens"_a, "corners"_a, "cells"_a, "light"_a, "limit"_a);

    m.def(
        "measure_corners",
        [](const Aligner& aligner, const py::array_t<std::uint8_t>& atlas, const Floats& table,
           const py::array_t<std::uint8_t>& full, const Lens& lens, const Light& light, const py::object& state,
           const Bytes& black, const Doubles& inlier_share, const Doubles& scale, const Doubles& corners,
           const Thresholds& limit) {
            Alignment all = alignment_of(state, black);
            const std::vector<AlignedMarker> markers = all.markers(aligner.count * aligner.count, aligner.cells);
            const py::ssize_t count = markers.size();
            check(inlier_share, {count}, "inlier_share"), check(scale, {8}, "scale");
            check(corners, {count, 4, 2}, "corners");
            Doubles moved = copy_of(corners);
            py::array_t<double> information({count, py::ssize_t(8), py::ssize_t(8)});
            const Measured image = measured_of(atlas, table, full, light, false);
            for (py::ssize_t m = 0; m < count; ++m)
                measure_corners(image, lens, aligner, markers[m], inlier_share.at(m), scale.data(), limit,
                                moved.mutable_data() + 8 * m, information.mutable_data() + 64 * m, nullptr);
            return py::make_tuple(moved, information);
        },
        py::kw_only(), "aligner"_a, "atlas"_a, "table"_a, "full"_a, "lens"_a, "light"_a, "state"_a, "black"_a,
        "inlier_share"_a, "scale"_a, "corners"_a, "limit"_a);

    m.def(
        "solve_poses",
        [](const Doubles& corners, const Doubles& sizes, const Lens& lens, const Doubles& information) {
            const py::ssize_t count = corners.shape(0);
            check(corners, {count, 4, 2}, "corners"), check(sizes, {count}, "sizes");
            check(information, {count, 8, 8}, "information");
            py::list all;
            for (py::ssize_t m = 0; m < count; ++m) {
                std::vector<Solution> both(2);
                both.resize(solve_pose(corners.data() + 8 * m, sizes.at(m), lens, information.data() + 64 * m, both.data()));
                all.append(array_of(both));
            }
            return all;
        },
        py::kw_only(), "corners"_a, "sizes"_a, "lens"_a, "information"_a);

    py::class_<LocalDecoder>(m, "LocalDecoder")
        .def(py::init([](const Floats& rim, const Floats& points, const Bytes& of_code, const Bytes& costs) {
                 check(rim, {3, kAny}, "rim"), check(points, {3, 6 * of_code.size()}, "points");
                 py::ssize_t in_code = 0;
                 for (py::ssize_t i = 0; i < of_code.size(); ++i) in_code += of_code.data()[i] != 0;
                 check(costs, {3 * in_code, kAny}, "costs");
                 return LocalDecoder{int(of_code.size()), int(costs.shape(1)), vector_of(rim), vector_of(points),
                                     vector_of(of_code), vector_of(costs)};
             }),
             py::kw_only(), "rim"_a, "points"_a, "of_code"_a, "costs"_a)
        .def(
            "match",
            [](const LocalDecoder& self, const py::array_t<std::uint8_t>& smooth, const Doubles& h,
               const Thresholds& limit) {
                check(h, {kAny, 3, 3}, "h");
                const Image image = image_of(smooth);
                std::vector<LocalMatch> found;
                {
                    Unlocked unlocked;
                    for (py::ssize_t m = 0; m < h.shape(0); ++m) found.push_back(self.match(image, h.data() + 9 * m, limit));
                }
                return array_of(found);
            },
            py::kw_only(), "smooth"_a, "h"_a, "limit"_a)
        .def(
            "rim",
            [](const LocalDecoder& self, const py::array_t<std::uint8_t>& smooth, const Doubles& h,
               const Thresholds& limit) {
                check(h, {kAny, 3, 3}, "h");
                Doubles share = line_of<double>(h.shape(0)), contrast = line_of<double>(h.shape(0));
                for (py::ssize_t m = 0; m < h.shape(0); ++m)
                    self.rim_of(image_of(smooth), h.data() + 9 * m, limit, share.mutable_data(m), contrast.mutable_data(m));
                return py::make_tuple(share, contrast);
            },
            py::kw_only(), "smooth"_a, "h"_a, "limit"_a);

    m.def(
        "contrasts",
        [](const py::array_t<std::uint8_t>& smooth, const Doubles& h, const Floats& points, const Thresholds& limit) {
            check(h, {kAny, 3, 3}, "h"), check(points, {3, kAny}, "points");
            const py::ssize_t pairs = points.shape(1) / 2;
            check(points, {3, 2 * pairs}, "points");
            py::array_t<float> seen({h.shape(0), pairs});
            for (py::ssize_t m = 0; m < h.shape(0); ++m)
                contrasts(image_of(smooth), h.data() + 9 * m, points.data(), pairs, limit, seen.mutable_data() + pairs * m);
            return seen;
        },
        py::kw_only(), "smooth"_a, "h"_a, "points"_a, "limit"_a);

    py::class_<Search>(m, "Search")
        .def(py::init([](const CoarseDecoder& decoder, const Aligner& aligner, const Appearance& appearance,
                         const Reader& reader, const Doubles& scale, const Bytes& black_words, const Integers& edges) {
                 check(scale, {8}, "scale"), check(black_words, {decoder.all_words, aligner.cells, aligner.cells}, "black_words");
                 check(edges, {decoder.all_words}, "edges");
                 return Search{decoder, aligner, appearance, reader, vector_of(scale), vector_of(black_words),
                               vector_of(edges)};
             }),
             py::kw_only(), "decoder"_a, "aligner"_a, "appearance"_a, "reader"_a, "scale"_a, "black_words"_a, "edges"_a,
             py::keep_alive<1, 2>(), py::keep_alive<1, 3>(), py::keep_alive<1, 4>(), py::keep_alive<1, 5>())
        .def(
            "find",
            [](const Search& self, const py::array_t<std::uint8_t>& smooth, const py::array_t<std::uint8_t>& atlas,
               const Floats& table, const py::array_t<std::uint8_t>& full, const Lens& lens, const Light& light, bool ask,
               double noise, const Doubles& quads, const Doubles& sizes, std::int64_t most, std::int64_t first,
               const Thresholds& limit, const py::object& ended) {
                check(quads, {kAny, 4, 2}, "quads"), check(sizes, {256}, "sizes");
                const Image image = image_of(smooth);
                const Measured measured = measured_of(atlas, table, full, light, ask);
                SearchResult found;
                {
                    const bool explain = !ended.is_none();
                    Unlocked unlocked;
                    found = self.find(image, measured, lens, noise, vector_of(quads), sizes.data(),
                                      turn_of(most, first), limit, explain);
                }
                extend(ended, found.ended);
                return py::dict("markers"_a = array_of(found.markers), "unsure"_a = array_of(found.unsure),
                                "well_read"_a = array_of(found.well_read),
                                "left_out"_a = found.left_out,
                                "refined"_a = array_of(found.refined, {py::ssize_t(found.refined.size()) / 8, 4, 2}));
            },
            py::kw_only(), "smooth"_a, "atlas"_a, "table"_a, "full"_a, "lens"_a, "light"_a, "ask"_a, "noise"_a,
            "quads"_a, "sizes"_a, "most"_a, "first"_a, "limit"_a, "ended"_a = py::none());
}
