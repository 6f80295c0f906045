/// EXR files of any other renderer, from their headers to an imported sequence. Behind a file may stand a mark and
/// bytes that choose how it is imported.
#include "target.h"

#include <equistream/error.h>
#include <equistream/sequence.h>
#include <host-adapters/import/import.h>
#include <tests/unit/plugin/export/frame_fixture.h>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfMultiView.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

namespace equistream::fuzz {

namespace {

constexpr std::string_view mark = "HOW TO IMPORT IT";

/// All that `equistream import` may be told. Without a mark: that it is a sphere.
files::ImportSettings settings_of(Choices choices) {
    files::ImportSettings settings;
    settings.camera = choices.one_of(std::array{"equirect", "auto", "perspective"});
    settings.preset =
        choices.one_of(std::array{"auto", "none", "cycles", "equistream", "luxcore", "mitsuba", "pbrt", "x"});
    settings.colour_space = choices.one_of(std::array{"auto", "rec709", "rec2020", "acescg", "aces2065-1", "x"});
    if (choices.yes())
        settings.fov_x_rad = 1.2;
    files::Overrides& over = settings.overrides;
    if (const int kind = choices.below(4); kind > 0)
        over.depth = files::DepthKind(kind - 1);
    for (auto* const motion : {&over.backward, &over.forward})
        if (choices.yes()) {
            constexpr std::array words = {"from-previous,ndc", "to-next,normalised,y-up", "from-next", "", "x"};
            *motion = files::parse_motion(choices.one_of(words), "--backward");
        }
    if (const int space = choices.below(4); space > 0)
        over.normals = files::NormalSpace(space - 1);
    const int flags = choices.below(64);
    if (flags & 1)
        over.normals_encoded = true;
    if (flags & 2)
        over.mirrored = true;
    if (flags & 4)
        over.z_up = true;
    if (flags & 8)
        over.near_plane_m = 0.1;
    if (flags & 16)
        over.forward_at = 0.25;
    if (flags & 32)
        over.miss_value = 1.5;
    static const std::filesystem::path csv =
        scratch_file("head.csv", bytes_of("0,0,0,0,1,0,0,0\n1,0,1,0,0.8,0,0.6,0\n"));
    if (choices.yes())
        settings.path = csv;
    const int window = choices.below(3);
    settings.window = window > 0;
    settings.density = window == 2 ? 64 : 0;
    settings.corner = {16 * choices.below(5), 0};
    constexpr std::array channels = {"",
                                     "depth=none",
                                     "colour=ViewLayer.Combined",
                                     "colour=R+G+B, depth=Z",
                                     "depth=P",
                                     "backward=ViewLayer.Vector,forward=ViewLayer.Vector.Z+ViewLayer.Vector.W",
                                     "object_id=ViewLayer.IndexOB.X,normal=N",
                                     "albedo=gone",
                                     "nothing=R",
                                     "depth="};
    if (const std::string text = choices.one_of(channels); !text.empty())
        over.channels = files::parse_channels(text);
    return settings;
}

/// Without writing anything: larger pictures take long.
void convert(const files::ImportSettings& settings, files::ImportPlan& plan) {
    files::ForeignExr file(settings.sources.front());
    const files::Conversion conversion{plan.conventions, plan.camera, {}, {}, {}, plan.colour_to_rec709};
    for (const files::PlannedView& view : plan.views)
        files::convert_frame({&file}, view.map, conversion, {}, plan.notes);
}

void take_foreign(Bytes bytes) {
    const auto found = std::find_end(bytes.begin(), bytes.end(), mark.begin(), mark.end());
    const auto file_bytes = std::size_t(found - bytes.begin());
    const Bytes chosen = bytes.subspan(std::min(bytes.size(), file_bytes + mark.size()));
    files::ImportSettings settings = settings_of(Choices(chosen));
    settings.sources = {scratch_file("foreign.0001.exr", bytes.first(file_bytes)).string()};
    settings.out = std::filesystem::path(settings.sources.front()).parent_path() / "imported";
    settings.overwrite = true;
    files::ImportPlan plan = files::make_plan(settings);
    require(!plan.table().empty(), "there is something to say");
    constexpr int max_pixels = 128 * 64;
    if (width_of(plan.camera) * std::int64_t(height_of(plan.camera)) > max_pixels)
        return convert(settings, plan);
    std::size_t frames = 0;
    std::filesystem::remove_all(settings.out);
    files::run_import(settings, plan, [&](std::size_t count, std::int64_t) { frames = count; });
    require(frames == plan.views.size(), "there is a frame of every view");
    for (const auto& view : std::filesystem::directory_iterator(settings.out)) {
        const Frame frame = read_exr(view.path() / frame_file_name(1));
        require(frame.planes.size() + frame.ids.size() == read_manifest(view.path()).planes.size(),
                "an imported frame has the planes of its sequence");
    }
}

struct Part {
    std::string name, view;
    std::vector<std::string> channels;  ///< behind # of whole numbers
};

/// Positive numbers, as distances are.
std::vector<std::uint8_t> made(const std::vector<Part>& parts, const std::function<void(Imf::Header&)>& change,
                               Imath::Box2i data = {{0, 0}, {31, 15}}) {
    std::vector<Imf::Header> headers;
    for (const Part& part : parts) {
        Imf::Header header(32, 16);
        header.dataWindow() = data;
        header.compression() = Imf::ZIP_COMPRESSION;
        header.setType(Imf::SCANLINEIMAGE);
        if (!part.name.empty())
            header.setName(part.name);
        if (!part.view.empty())
            header.setView(part.view);
        for (const std::string& name : part.channels)
            header.channels().insert(name.substr(name.find_first_not_of('#')),
                                     Imf::Channel(name.front() == '#' ? Imf::UINT : Imf::FLOAT));
        change(header);
        headers.push_back(header);
    }
    const std::filesystem::path file = scratch_file("seed.exr", {});
    {
        Imf::MultiPartOutputFile out(file.c_str(), headers.data(), int(headers.size()));
        const int width = data.max.x - data.min.x + 1, height = data.max.y - data.min.y + 1;
        std::vector<float> real(std::size_t(width) * std::size_t(height));
        std::vector<std::uint32_t> whole(real.size());
        for (std::size_t i = 0; i < real.size(); ++i) {
            real[i] = float(1 + i % 13) / 8;
            whole[i] = std::uint32_t(i % 5);
        }
        for (int i = 0; i < int(headers.size()); ++i) {
            Imf::FrameBuffer buffer;
            for (auto c = headers[std::size_t(i)].channels().begin(); c != headers[std::size_t(i)].channels().end();
                 ++c) {
                char* const samples = c.channel().type == Imf::UINT ? reinterpret_cast<char*>(whole.data())
                                                                    : reinterpret_cast<char*>(real.data());
                char* const origin = samples - 4 * (std::ptrdiff_t(data.min.y) * width + data.min.x);
                buffer.insert(c.name(), Imf::Slice(c.channel().type, origin, 4, 4 * std::size_t(width)));
            }
            Imf::OutputPart part(out, i);
            part.setFrameBuffer(buffer);
            part.writePixels(height);
        }
    }
    return bytes_of_file(file);
}

void add_text(Imf::Header& header, const char* name, const char* text) {
    header.insert(name, Imf::StringAttribute(text));
}

/// Of a camera at (1, 2, 3).
void add_camera(Imf::Header& header, bool columns, float z) {
    const Imath::M44f rows(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, z, 0, -1, -2, -3, 1);
    Imf::addWorldToCamera(header, columns ? rows.transposed() : rows);
    const Imath::M44f to_ndc(0.5f, 0, 0, 0, 0, 1, 0, 0, 0, 0, z, z, -0.5f, -2, -3, -3);
    Imf::addWorldToNDC(header, columns ? to_ndc.transposed() : to_ndc);
}

std::vector<std::uint8_t> told(std::vector<std::uint8_t> file, std::initializer_list<std::uint8_t> how) {
    file.insert(file.end(), mark.begin(), mark.end());
    file.insert(file.end(), how);
    return file;
}

const std::vector<std::string> of_cycles = {
    "ViewLayer.Combined.R", "ViewLayer.Combined.G", "ViewLayer.Combined.B", "ViewLayer.Combined.A",
    "ViewLayer.Depth.Z",    "ViewLayer.Vector.X",   "ViewLayer.Vector.Y",   "ViewLayer.Vector.Z",
    "ViewLayer.Vector.W",   "ViewLayer.Normal.X",   "ViewLayer.Normal.Y",   "ViewLayer.Normal.Z",
    "ViewLayer.DiffCol.R",  "ViewLayer.DiffCol.G",  "ViewLayer.DiffCol.B",  "ViewLayer.IndexOB.X",
    "#ViewLayer.IndexMA.X", "ViewLayer.Crypto00.R", "ViewLayer.Noisy.R",    "ViewLayer.Z.Z"};

/// One view in each of a few parts, by part names, by channel names, and by a list of views.
Seeds views() {
    const auto nothing = [](Imf::Header&) {};
    const auto listed = [](Imf::Header& header) {
        Imf::addMultiView(header, {"right", "left", "middle"});
        header.insert("framesPerSecond", Imf::RationalAttribute(Imf::Rational(24, 1)));
    };
    return {
        made(
            {{"rgb.left", "left", {"R", "G", "B"}}, {"rgb.right", "right", {"R", "G", "B"}}, {"Z.left", "left", {"Z"}}},
            nothing),
        made({{"", "", {"R", "G", "B", "left.R", "left.G", "left.B", "middle.R"}}}, listed)};
}

Seeds foreign_seeds() {
    const std::filesystem::path file = scratch_file("seed.exr", {});
    Seeds found = views();
    for (const bool single_part : {false, true}) {
        Frame frame = testing::test_frame(single_part ? 5 : 12, single_part ? 3 : 18);
        for (const char* plane : {"depth", "virtual_depth"})
            for (float& distance_m : frame.planes.at(plane).samples())
                distance_m = std::abs(distance_m);
        write_exr(file, frame, {.single_part = single_part});
        found.push_back(bytes_of_file(file));
    }
    const auto blender = made({{"", "", of_cycles}}, [](Imf::Header& header) {
        add_text(header, "RenderTime", "0");
        add_text(header, "Scene", "one");
        Imf::addChromaticities(header, Imf::Chromaticities({0.7f, 0.3f}, {0.2f, 0.7f}, {0.1f, 0.1f}, {0.31f, 0.33f}));
    });
    found.push_back(blender);
    // Of a flat view, told by --fov; with poses of a path; a part of a sphere; and named channels.
    found.push_back(told(blender, {2, 2, 0, 1}));
    found.push_back(told(blender, {0, 2, 1, 0, 0, 1, 0, 1, 1, 1, 5, 1}));
    found.push_back(told(blender, {0, 2, 0, 0, 0, 0, 0, 2, 2, 0, 2, 1}));
    found.push_back(told(blender, {0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 5}));
    found.push_back(told(blender, {0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2}));
    const auto cut = made({{"", "", {"R", "G", "B", "Z"}}}, [](Imf::Header&) {}, {{3, 0}, {31, 15}});
    found.push_back(told(cut, {0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0}));
    found.push_back(cut);
    const std::vector<std::string> of_pbrt = {"R",   "G", "B",    "P.X",  "P.Y",      "P.Z",      "N.X",     "N.Y",
                                              "N.Z", "u", "dzdx", "dzdy", "Albedo.R", "Albedo.G", "Albedo.B"};
    const auto pbrt = made({{"", "", of_pbrt}}, [](Imf::Header& header) { add_camera(header, true, 1); });
    found.push_back(pbrt);
    found.push_back(told(pbrt, {2, 6, 2, 1}));
    const std::vector<std::string> of_mitsuba = {"R", "G", "B", "dd.T", "nn.X", "nn.Y", "nn.Z", "shape_index.I"};
    found.push_back(made({{"", "", of_mitsuba}}, [](Imf::Header& header) {
        add_text(header, "generatedBy", "Mitsuba 3");
        add_camera(header, false, -1);
    }));
    const std::vector<std::string> of_luxcore = {"RGB.R",   "RGB.G",   "RGB.B",      "DEPTH.R",
                                                 "DEPTH.G", "DEPTH.B", "OBJECT_ID.Y"};
    found.push_back(
        told(made({{"", "", of_luxcore}}, [](Imf::Header& header) { add_camera(header, false, 1); }), {0, 4}));
    return found;
}

}  // namespace

const Target foreign_exr_target{"foreign_exr", take_foreign, foreign_seeds, 300, damage_attributes};

}  // namespace equistream::fuzz
