#include "bindings.h"

#include <equistream/aov.h>
#include <equistream/aov_groups.h>
#include <equistream/sequence_writer.h>
#include <equistream/text.h>
#include <scenes/library/scene.h>

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

namespace equistream::python {

namespace {

namespace fs = std::filesystem;

using PlanesIn = std::vector<std::pair<std::string, nb::object>>;

/// Each plane's samples become an array without a copy.
nb::tuple read(const fs::path& file, const std::vector<std::string>& planes) {
    Frame frame;
    {
        const nb::gil_scoped_release release;
        frame = read_exr(file, planes);
    }
    nb::dict arrays;
    for (const AovInfo& aov : aov_catalogue()) {
        const std::string name(aov.name);
        if (const auto plane = frame.planes.find(name); plane != frame.planes.end())
            arrays[name.c_str()] = to_array(std::move(plane->second));
        if (const auto ids = frame.ids.find(name); ids != frame.ids.end())
            arrays[name.c_str()] = to_array(std::move(ids->second));
    }
    return nb::make_tuple(frame.info, arrays);
}

Frame make_frame(const FrameInfo& info, const PlanesIn& planes) {
    Frame frame;
    frame.info = info;
    for (const auto& [name, array] : planes) {
        const std::optional<AovInfo> aov = find_aov(name);
        if (!aov)
            throw InputError(expected_found("plane", "a name of the AOV catalogue", "'" + name + "'"));
        if (aov->type == SampleType::id)
            frame.ids[name] = copy_of(nb::cast<ArrayIn<std::uint32_t>>(array));
        else
            frame.planes[name] = copy_of(nb::cast<ArrayIn<float>>(array));
    }
    return frame;
}

void check(const Frame& frame) {
    for (const auto& [name, plane] : frame.planes)
        require_plane_values(*find_aov(name), plane.view());
}

std::int64_t write(const fs::path& file, const FrameInfo& info, const PlanesIn& planes, bool single_part) {
    const Frame frame = make_frame(info, planes);
    const nb::gil_scoped_release release;
    check(frame);
    return write_exr(file, frame, {.single_part = single_part});
}

class Writer {
public:
    Writer(const fs::path& folder, const FrameInfo& shared, const std::vector<std::string>& planes, bool overwrite,
           const std::string& fingerprint) {
        SequenceSettings settings;
        settings.folder = folder;
        settings.overwrite = overwrite;
        settings.manifest.shared = shared;
        settings.manifest.planes = planes;
        settings.manifest.single_part = false;
        settings.manifest.command = "equistream (Python)";
        settings.manifest.fingerprint = sequence_fingerprint(settings.manifest, fingerprint);
        const nb::gil_scoped_release release;
        writer_ = std::make_unique<SequenceWriter>(std::move(settings));
    }
    bool keeps(std::int64_t index) const { return open().keeps_frame(index); }
    void write(const FrameInfo& info, const PlanesIn& planes) {
        const Frame frame = make_frame(info, planes);
        SequenceWriter& writer = open();
        waiting_.run([&] {
            check(frame);
            writer.write(frame);
        });
    }
    FrameInfo shared() const { return open().manifest().shared; }
    /// Refused while another thread writes.
    void close() {
        waiting_.run([] {});
        writer_.reset();
    }

private:
    SequenceWriter& open() const {
        if (!writer_)
            throw InputError(expected_found("SequenceWriter", "an open writer", "one that was closed"));
        return *writer_;
    }
    Waiting waiting_{"SequenceWriter"};
    std::unique_ptr<SequenceWriter> writer_;
};

nb::dict manifest_of(const fs::path& folder) {
    const Manifest manifest = read_manifest(folder);
    nb::dict found;
    found["shared"] = manifest.shared;
    found["planes"] = manifest.planes;
    found["command"] = manifest.command;
    found["fingerprint"] = manifest.fingerprint;
    return found;
}

nb::list catalogue() {
    nb::list rows;
    for (const AovInfo& aov : aov_catalogue()) {
        nb::dict row;
        row["name"] = std::string(aov.name);
        row["group"] = std::string(aov.group);
        nb::list channels;
        for (const std::string_view channel : aov.channels)
            channels.append(std::string(channel));
        row["channels"] = nb::tuple(channels);
        row["is_id"] = aov.type == SampleType::id;
        row["unit"] = std::string(aov.unit);
        row["meaning"] = std::string(aov.meaning);
        rows.append(row);
    }
    return rows;
}

}  // namespace

void bind_frames(nb::module_& m) {
    m.def("read_exr", &read, nb::arg("file"), nb::arg("planes"));
    m.def("read_exr_info", &read_exr_info, nb::arg("file"), nb::call_guard<nb::gil_scoped_release>());
    m.def("write_exr", &write, nb::arg("file"), nb::arg("info"), nb::arg("planes"), nb::arg("single_part"));
    m.def(
        "list_frames", [](const fs::path& folder) { return list_frames(folder); }, nb::arg("folder"));
    m.def(
        "frame_file_name", [](std::int64_t index) { return frame_file_name(index); }, nb::arg("index"));
    m.def("read_manifest", &manifest_of, nb::arg("folder"));
    m.def("catalogue", &catalogue);
    m.def(
        "planes_of_groups", [](const std::string& groups) { return parse_aov_groups(groups); }, nb::arg("groups"));
    nb::class_<Writer>(m, "SequenceWriter")
        .def(nb::init<const fs::path&, const FrameInfo&, const std::vector<std::string>&, bool, const std::string&>(),
             nb::arg("folder"), nb::arg("shared"), nb::arg("planes"), nb::arg("overwrite"), nb::arg("fingerprint"))
        .def("keeps", &Writer::keeps, nb::arg("index"))
        .def("write", &Writer::write, nb::arg("info"), nb::arg("planes"))
        .def("close", &Writer::close);
    nb::class_<PosePath>(
        m, "PosePath",
        "Poses over time: linear in position, slerp in orientation, held before the first and after the last key.")
        .def(
            "__init__",
            [](PosePath* self, const std::vector<std::pair<double, Pose>>& keys) {
                if (keys.empty())
                    throw InputError(expected_found("PosePath", "at least one key", "none"));
                std::vector<PosePath::Key> list;
                for (const auto& [time_s, pose] : keys)
                    list.push_back({time_s, pose});
                new (self) PosePath(std::move(list), "PosePath");
            },
            nb::arg("keys"))
        .def_static(
            "read", [](const fs::path& file) { return read_path_csv(file); }, nb::arg("file"),
            "Reads a CSV: time_s, position x y z in metres, orientation quaternion w x y z.")
        .def(
            "write", [](const PosePath& path, const fs::path& file) { write_path_csv(file, path); }, nb::arg("file"),
            "Writes the same CSV.")
        .def("at", &PosePath::at, nb::arg("time_s"), "The pose at a time.")
        .def_prop_ro("duration_s", &PosePath::duration_s, "Time of the last key.")
        .def_prop_ro(
            "keys",
            [](const PosePath& path) {
                std::vector<std::pair<double, Pose>> keys;
                for (const PosePath::Key& key : path.keys())
                    keys.emplace_back(key.time_s, key.pose);
                return keys;
            },
            "(time_s, Pose) pairs, ascending.")
        .def("__len__", [](const PosePath& path) { return path.keys().size(); })
        .def("__repr__", [](const PosePath& path) {
            return formatted("PosePath(%zu keys, %g s)", path.keys().size(), path.duration_s());
        });
}

}  // namespace equistream::python
