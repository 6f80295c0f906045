#include "foreign_exr.h"

#include <equistream/error.h>
#include <equistream/text.h>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChromaticitiesAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfMultiView.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfRationalAttribute.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace equistream::files {

namespace fs = std::filesystem;

namespace {

constexpr int max_parts = 256;
constexpr int max_channels = 2048;
constexpr std::int64_t max_around = 64, always_allowed_display = 1 << 20;  // what is around pixels costs a file nothing
constexpr std::int64_t max_block = 1 << 20;
/// No lossless coding of EXR does better than deflate's 1032:1; DCT coding of a constant does.
constexpr std::int64_t max_ratio = 1100, max_lossy_ratio = 10000;

struct Box {
    std::int64_t x = 0, y = 0, width = 0, height = 0;
};

Box box_of(const Imath::Box2i& box) {
    return {box.min.x, box.min.y, std::int64_t{box.max.x} - box.min.x + 1, std::int64_t{box.max.y} - box.min.y + 1};
}

std::vector<std::string> components(const std::string& name) {
    std::vector<std::string> words;
    for (std::size_t begin = 0; begin <= name.size();) {
        const std::size_t end = std::min(name.find('.', begin), name.size());
        words.push_back(name.substr(begin, end - begin));
        begin = end + 1;
    }
    return words;
}

std::string joined(const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& word : words)
        text += (text.empty() ? "" : ".") + word;
    return text;
}

/// A view is a component of the channel's name, or an attribute of its part; the first of a multi-view file is meant
/// where neither says.
void find_view(ForeignChannel& channel, const Imf::Header& header) {
    channel.plain = channel.name;
    if (header.hasView()) {
        channel.view = header.view();
        std::vector<std::string> words = components(channel.name);
        std::erase(words, channel.view);
        channel.plain = joined(words);
        return;
    }
    if (!Imf::hasMultiView(header))
        return;
    const Imf::StringVector& views = Imf::multiView(header);
    std::vector<std::string> words = components(channel.name);
    for (const std::string& view : views)
        if (const auto found = std::find(words.begin(), words.end(), view); found != words.end()) {
            words.erase(found);
            channel.view = view;
            channel.plain = joined(words);
            return;
        }
    if (!views.empty())
        channel.view = views.front();
}

/// Part "Depth" with channel "Z" is Depth.Z; part "rgba" with "R" stays R, and a name that has its layer keeps it.
void add_part_name(ForeignChannel& channel) {
    std::string part = channel.part;
    if (!channel.view.empty()) {
        std::vector<std::string> words = components(part);
        std::erase(words, channel.view);
        part = joined(words);
    }
    if (!part.empty() && channel.plain.find('.') == std::string::npos)
        channel.plain = part + "." + channel.plain;
}

}  // namespace

struct ForeignExr::State {
    fs::path file;
    std::unique_ptr<Imf::MultiPartInputFile> input;
    Box display;
    std::vector<ForeignChannel> channels;

    [[noreturn]] void refuse(const std::string& expected, std::string found) const {
        // Names out of a damaged file are in no encoding.
        std::ranges::replace_if(
            found, [](char c) { return static_cast<unsigned char>(c) > 126; }, '?');
        throw InputError(expected_found(file.string(), expected, found));
    }
    void open();
    void check_part(int part, std::uintmax_t file_bytes) const;
    void list_channels(int part);
    const Imf::Header& header(int part = 0) const { return input->header(part); }
    std::optional<glm::dmat4> matrix(const char* name) const;

    /// One channel over its part's data window to put it into.
    template <typename Sample>
    Image<Sample> add_slice(const ForeignChannel& channel, Imf::PixelType type, Imf::FrameBuffer& buffer) const;
    void decode(int part, const Imf::FrameBuffer& buffer, const std::string& what) const;
    template <typename Sample>
    Image<Sample> shown(const ForeignChannel& channel, Image<Sample> whole, Sample outside) const;

    std::map<std::pair<int, std::string>, FloatImage> decoded;  ///< by part and name, over the data window
};

void ForeignExr::State::open() {
    std::error_code error;
    const std::uintmax_t bytes = fs::file_size(file, error);
    if (error || !fs::is_regular_file(file))
        refuse("an EXR file", error ? error.message() : "not a regular file");
    require_attributes_within(file, bytes);
    Imf::Header::setMaxImageSize(max_image_side, max_image_side);
    Imf::Header::setMaxTileSize(max_image_side, max_image_side);
    try {
        input = std::make_unique<Imf::MultiPartInputFile>(file.c_str(), 0, false);
    } catch (const std::exception& problem) {
        refuse("an EXR file", problem.what());
    }
    if (input->parts() < 1 || input->parts() > max_parts)
        refuse("1 to " + std::to_string(max_parts) + " parts", std::to_string(input->parts()));
    display = box_of(header().displayWindow());
    if (display.width < 1 || display.height < 1 || display.width > max_image_side || display.height > max_image_side ||
        display.width * display.height > max_image_pixels)
        refuse("at most " + std::to_string(max_image_side) + " pixels a side",
               std::to_string(display.width) + "x" + std::to_string(display.height));
    for (int part = 0; part < input->parts(); ++part) {
        check_part(part, bytes);
        list_channels(part);
    }
}

void ForeignExr::State::check_part(int part, std::uintmax_t file_bytes) const {
    const Imf::Header& part_header = header(part);
    if (part_header.hasType() && Imf::isDeepData(part_header.type()))
        refuse("flat pixels", "deep data");
    const Box data = box_of(part_header.dataWindow());
    if (data.width < 1 || data.height < 1 || data.width * data.height > max_image_pixels)
        refuse("a data window of 1 to " + std::to_string(max_image_pixels) + " pixels",
               std::to_string(data.width) + "x" + std::to_string(data.height));
    if (display.width * display.height > std::max(max_around * data.width * data.height, always_allowed_display))
        refuse("a display window of at most " + std::to_string(max_around) + " times the pixels",
               std::to_string(display.width) + "x" + std::to_string(display.height) + " around " +
                   std::to_string(data.width) + "x" + std::to_string(data.height));
    const Box shown = box_of(part_header.displayWindow());
    if (shown.width != display.width || shown.height != display.height)
        refuse("parts of one size", std::to_string(shown.width) + "x" + std::to_string(shown.height) + " besides " +
                                        std::to_string(display.width) + "x" + std::to_string(display.height));
    std::int64_t pixel_bytes = 0;
    for (auto c = part_header.channels().begin(); c != part_header.channels().end(); ++c)
        pixel_bytes += c.channel().type == Imf::HALF ? 2 : 4;
    const bool lossy = part_header.compression() >= Imf::B44_COMPRESSION;
    // Whole blocks of lines and whole tiles are decoded, however few of their pixels are there.
    const std::int64_t tile =
        part_header.hasTileDescription()
            ? std::int64_t{part_header.tileDescription().xSize} * part_header.tileDescription().ySize
            : data.width * (part_header.compression() == Imf::DWAB_COMPRESSION ? 256 : 32);
    if (tile > std::max(4 * data.width * data.height, max_block))
        refuse("tiles or blocks of at most " + std::to_string(max_block) + " pixels", std::to_string(tile));
    if (pixel_bytes * data.width * data.height / (lossy ? max_lossy_ratio : max_ratio) > std::int64_t(file_bytes))
        refuse("a whole EXR file", std::to_string(file_bytes) + " bytes for " + std::to_string(data.width) + "x" +
                                       std::to_string(data.height) + " pixels");
    if (!input->partComplete(part))
        refuse("a whole EXR file", "one that ends early");
}

void ForeignExr::State::list_channels(int part) {
    const Imf::Header& part_header = header(part);
    for (auto c = part_header.channels().begin(); c != part_header.channels().end(); ++c) {
        ForeignChannel channel;
        channel.name = c.name();
        channel.part = part_header.hasName() ? part_header.name() : std::string();
        channel.part_index = part;
        channel.is_id = c.channel().type == Imf::UINT;
        channel.is_half = c.channel().type == Imf::HALF;
        if (quotable(channel.name, 200) != channel.name)
            refuse("channel names in printable characters", "'" + channel.name + "'");
        find_view(channel, part_header);
        add_part_name(channel);
        channels.push_back(std::move(channel));
        if (channels.size() > max_channels)
            refuse("at most " + std::to_string(max_channels) + " channels", "more");
    }
}

template <typename Sample>
Image<Sample> ForeignExr::State::add_slice(const ForeignChannel& channel, Imf::PixelType type,
                                           Imf::FrameBuffer& buffer) const {
    const Imf::Header& part_header = header(channel.part_index);
    const Imf::Channel* stored = part_header.channels().findChannel(channel.name.c_str());
    if (stored == nullptr || stored->xSampling != 1 || stored->ySampling != 1)
        refuse("channel " + channel.name + " without subsampling", "one with");
    const Box data = box_of(part_header.dataWindow());
    Image<Sample> whole(int(data.width), int(data.height), 1);
    // OpenEXR counts from the origin of coordinates, which the buffer need not hold.
    char* const origin =
        reinterpret_cast<char*>(whole.samples().data()) - (data.y * data.width + data.x) * std::int64_t(sizeof(Sample));
    buffer.insert(channel.name, Imf::Slice(type, origin, sizeof(Sample), sizeof(Sample) * std::size_t(data.width)));
    return whole;
}

void ForeignExr::State::decode(int part, const Imf::FrameBuffer& buffer, const std::string& what) const {
    const Box data = box_of(header(part).dataWindow());
    try {
        Imf::InputPart pixels(*input, part);
        pixels.setFrameBuffer(buffer);
        pixels.readPixels(int(data.y), int(data.y + data.height - 1));
    } catch (const std::exception& problem) {
        refuse(what + " whole", problem.what());
    }
}

template <typename Sample>
Image<Sample> ForeignExr::State::shown(const ForeignChannel& channel, Image<Sample> whole, Sample outside) const {
    const Box data = box_of(header(channel.part_index).dataWindow());
    const Box window = box_of(header(channel.part_index).displayWindow());
    if (window.x == data.x && window.y == data.y && window.width == data.width && window.height == data.height)
        return whole;
    Image<Sample> image(int(window.width), int(window.height), 1, outside);
    const std::int64_t first_x = std::max(window.x, data.x),
                       last_x = std::min(window.x + window.width, data.x + data.width);
    for (std::int64_t y = std::max(window.y, data.y); y < std::min(window.y + window.height, data.y + data.height); ++y)
        if (first_x < last_x)
            std::copy_n(whole.pixel(int(first_x - data.x), int(y - data.y)), last_x - first_x,
                        image.pixel(int(first_x - window.x), int(y - window.y)));
    return image;
}

ForeignExr::ForeignExr(const fs::path& file) : state_(std::make_unique<State>()) {
    state_->file = file;
    state_->open();
}
ForeignExr::~ForeignExr() = default;
ForeignExr::ForeignExr(ForeignExr&&) noexcept = default;

const fs::path& ForeignExr::file() const {
    return state_->file;
}
int ForeignExr::width() const {
    return int(state_->display.width);
}
int ForeignExr::height() const {
    return int(state_->display.height);
}
ForeignExr::Rectangle ForeignExr::pixels() const {
    std::int64_t left = 0, top = 0, right = state_->display.width, bottom = state_->display.height;
    for (int part = 0; part < state_->input->parts(); ++part) {
        const Box data = box_of(state_->header(part).dataWindow());
        const Box window = box_of(state_->header(part).displayWindow());
        left = std::max(left, data.x - window.x), right = std::min(right, data.x - window.x + data.width);
        top = std::max(top, data.y - window.y), bottom = std::min(bottom, data.y - window.y + data.height);
    }
    if (left >= right || top >= bottom)
        return {};
    return {int(left), int(top), int(right - left), int(bottom - top)};
}
const std::vector<ForeignChannel>& ForeignExr::channels() const {
    return state_->channels;
}

std::optional<double> ForeignExr::frames_per_second() const {
    const auto* rate = state_->header().findTypedAttribute<Imf::RationalAttribute>("framesPerSecond");
    const double value = rate == nullptr || rate->value().d == 0 ? 0 : double(rate->value());
    return value > 0.001 && value < 1000 ? std::optional(value) : std::nullopt;
}

std::optional<Chromaticities> ForeignExr::chromaticities() const {
    if (!Imf::hasChromaticities(state_->header()))
        return std::nullopt;
    const Imf::Chromaticities& c = Imf::chromaticities(state_->header());
    return Chromaticities{
        glm::dvec2{c.red.x, c.red.y}, {c.green.x, c.green.y}, {c.blue.x, c.blue.y}, {c.white.x, c.white.y}};
}

std::optional<glm::dmat4> ForeignExr::State::matrix(const char* name) const {
    const auto* attribute = header().findTypedAttribute<Imf::M44fAttribute>(name);
    if (attribute == nullptr)
        return std::nullopt;
    glm::dmat4 matrix;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) {
            matrix[i][j] = double(attribute->value()[i][j]);
            if (!std::isfinite(matrix[i][j]))
                refuse(std::string(name) + " of finite numbers", "NaN or infinity");
        }
    return matrix;
}

std::optional<glm::dmat4> ForeignExr::world_to_camera() const {
    return state_->matrix("worldToCamera");
}
std::optional<glm::dmat4> ForeignExr::world_to_ndc() const {
    return state_->matrix("worldToNDC");
}

bool ForeignExr::is_our_own() const {
    return state_->header().find("equistream:version") != state_->header().end();
}

bool ForeignExr::says_ods() const {
    const auto* camera = state_->header().findTypedAttribute<Imf::StringAttribute>("equistream:camera");
    return camera != nullptr && camera->value() == "ods";
}

std::string ForeignExr::software() const {
    for (const char* name : {"Software", "software", "generatedBy", "exr/writer", "writer"})
        if (const auto* text = state_->header().findTypedAttribute<Imf::StringAttribute>(name))
            return quotable(text->value(), 200);
    if (state_->header().findTypedAttribute<Imf::StringAttribute>("RenderTime") != nullptr &&
        state_->header().findTypedAttribute<Imf::StringAttribute>("Scene") != nullptr)
        return "Blender";
    return {};
}

void ForeignExr::decode(const std::vector<ForeignChannel>& channels) {
    std::map<int, Imf::FrameBuffer> buffers;
    for (const ForeignChannel& channel : channels)
        if (!state_->decoded.contains({channel.part_index, channel.name}))
            state_->decoded.emplace(std::pair(channel.part_index, channel.name),
                                    state_->add_slice<float>(channel, Imf::FLOAT, buffers[channel.part_index]));
    for (const auto& [part, buffer] : buffers)
        state_->decode(part, buffer, "part " + std::to_string(part));
}

FloatImage ForeignExr::read(const ForeignChannel& channel, float outside) const {
    const auto found = state_->decoded.find({channel.part_index, channel.name});
    if (found != state_->decoded.end())
        return state_->shown(channel, found->second, outside);
    Imf::FrameBuffer buffer;
    FloatImage whole = state_->add_slice<float>(channel, Imf::FLOAT, buffer);
    state_->decode(channel.part_index, buffer, "channel " + channel.name);
    return state_->shown(channel, std::move(whole), outside);
}

IdImage ForeignExr::read_ids(const ForeignChannel& channel) const {
    Imf::FrameBuffer buffer;
    IdImage whole = state_->add_slice<std::uint32_t>(channel, Imf::UINT, buffer);
    state_->decode(channel.part_index, buffer, "channel " + channel.name);
    return state_->shown(channel, std::move(whole), std::uint32_t{0});
}

}  // namespace equistream::files
