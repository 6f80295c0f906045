#include "compositing_exr.h"

#include <equistream/error.h>
#include <plugin/export/exr_session.h>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDeepFrameBuffer.h>
#include <OpenEXR/ImfDeepScanLineOutputFile.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStandardAttributes.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <string_view>

namespace equistream::compositing {

namespace {

namespace fs = std::filesystem;

/// What OpenEXR writes, to a file that appears when it is whole.
class AtomicStream : public Imf::OStream {
public:
    explicit AtomicStream(const fs::path& file) : Imf::OStream(file.c_str()), file_(file) {}
    void write(const char bytes[], int count) override {
        file_.write_at(bytes, std::size_t(count), position_);
        position_ += std::uint64_t(count);
    }
    std::uint64_t tellp() override { return position_; }
    void seekp(std::uint64_t position) override { position_ = position; }
    void commit() { file_.commit(); }

private:
    AtomicFile file_;
    std::uint64_t position_ = 0;
};

/// The frame's size, and all that the rendered file says of itself.
Imf::Header header_of(const View& view) {
    const FloatImage& colour = view.front.planes.at("colour");
    Imf::Header header(colour.width(), colour.height());
    static const std::set<std::string_view> own = {
        "channels", "chunkCount",       "compression",        "dataWindow",        "displayWindow", "lineOrder",
        "name",     "pixelAspectRatio", "screenWindowCenter", "screenWindowWidth", "type",          "version"};
    const Imf::MultiPartInputFile rendered(view.file.c_str());
    for (auto attribute = rendered.header(0).begin(); attribute != rendered.header(0).end(); ++attribute)
        if (!own.contains(attribute.name()) && !std::string_view(attribute.name()).starts_with("cryptomatte/"))
            header.insert(attribute.name(), attribute.attribute());
    return header;
}

half to_half(float value) {
    return half(std::clamp(value, -float(HALF_MAX), float(HALF_MAX)));
}

/// A surface's samples, in the order of `half_names`, then its distance.
struct Sample {
    std::array<half, 4> rgba;
    float z_m;
};

constexpr std::array half_names = {"R", "G", "B", "A"};

Sample sample_of(const float* colour, float depth_m) {
    return {{to_half(colour[0]), to_half(colour[1]), to_half(colour[2]), half(1)}, std::min(depth_m, sky_m)};
}

/// The samples of one picture, nearest first.
class DeepPixels {
public:
    explicit DeepPixels(const View& view)
        : width_(view.front.planes.at("colour").width()), height_(view.front.planes.at("colour").height()) {
        const FloatImage &colour = view.front.planes.at("colour"), &depth_m = view.front.planes.at("depth");
        for (int y = 0; y < height_; ++y)
            for (int x = 0; x < width_; ++x) {
                starts_.push_back(samples_.size());
                samples_.push_back(sample_of(colour.pixel(x, y), *depth_m.pixel(x, y)));
                if (view.hidden)
                    add_hidden(*view.hidden, x, y);
            }
        starts_.push_back(samples_.size());
        counts_.front = std::int64_t(width_) * height_;
    }

    const DeepCounts& counts() const { return counts_; }

    void write(Imf::DeepScanLineOutputFile& file) {
        // Channels of a sample lie side by side; of each pixel OpenEXR is told where its first one is.
        const std::size_t pixels = starts_.size() - 1;
        std::vector<unsigned> per_pixel(pixels);
        for (std::size_t i = 0; i < pixels; ++i)
            per_pixel[i] = unsigned(starts_[i + 1] - starts_[i]);
        Imf::DeepFrameBuffer buffer;
        const auto row = sizeof(unsigned) * std::size_t(width_);
        buffer.insertSampleCountSlice(
            Imf::Slice(Imf::UINT, reinterpret_cast<char*>(per_pixel.data()), sizeof(unsigned), row));
        std::vector<std::vector<char*>> pointers;
        const auto add = [&](const char* name, Imf::PixelType type, auto address) {
            std::vector<char*>& first = pointers.emplace_back(pixels);
            for (std::size_t i = 0; i < pixels; ++i)
                first[i] = reinterpret_cast<char*>(address(samples_[starts_[i]]));
            buffer.insert(name, Imf::DeepSlice(type, reinterpret_cast<char*>(first.data()), sizeof(char*),
                                               sizeof(char*) * std::size_t(width_), sizeof(Sample)));
        };
        for (std::size_t c = 0; c < half_names.size(); ++c)
            add(half_names[c], Imf::HALF, [c](Sample& sample) { return &sample.rgba[c]; });
        for (const char* name : {"Z", "ZBack"})
            add(name, Imf::FLOAT, [](Sample& sample) { return &sample.z_m; });
        file.setFrameBuffer(buffer);
        file.writePixels(height_);
    }

private:
    void add_hidden(const Frame& hidden, int x, int y) {
        const float depth_m = *hidden.planes.at("depth").pixel(x, y);
        if (std::isnan(depth_m))
            return;
        const Sample behind = sample_of(hidden.planes.at("colour").pixel(x, y), depth_m);
        if (!(behind.z_m > samples_.back().z_m)) {
            ++counts_.left_out;
            return;
        }
        samples_.push_back(behind);
        ++counts_.hidden;
    }

    int width_, height_;
    std::vector<Sample> samples_;
    std::vector<std::size_t> starts_;  // by pixel, and where the last one ends
    DeepCounts counts_;
};

/// One part of a file and the planes that its channels are of.
struct Part {
    Imf::Header header;
    struct Channel {
        std::string name;
        Imf::PixelType type;
        const FloatImage* plane;
        int channel;
    };
    std::vector<Channel> channels;
};

std::vector<Part> parts_of(const View& view, bool one_of_several, std::vector<FloatImage>& filled) {
    const Imf::Header described = header_of(view);
    const auto part = [&](const std::string& name) {
        Part made{described, {}};
        made.header.setName(one_of_several ? name + "." + view.name : name);
        made.header.setType(Imf::SCANLINEIMAGE);
        made.header.compression() = Imf::ZIP_COMPRESSION;
        made.header.setView(view.name);
        return made;
    };
    std::vector<Part> parts;
    Part rgba = part("rgba");
    const FloatImage& colour = view.front.planes.at("colour");
    for (int c = 0; c < 4; ++c)
        rgba.channels.push_back({half_names[std::size_t(c)], Imf::HALF, &colour, c});
    parts.push_back(std::move(rgba));
    if (const auto depth = view.front.planes.find("depth"); depth != view.front.planes.end()) {
        Part z = part("depth");
        z.channels.push_back({"Z", Imf::FLOAT, &depth->second, 0});
        parts.push_back(std::move(z));
    }
    if (!view.hidden)
        return parts;
    Part behind = part("hidden");
    FloatImage& hidden = filled.emplace_back(view.hidden->planes.at("colour"));
    for (int c = 0; c < 4; ++c)
        behind.channels.push_back({std::string("hidden.") + half_names[std::size_t(c)], Imf::HALF, &hidden, c});
    FloatImage& depth_m = filled.emplace_back(view.hidden->planes.at("depth"));
    for (std::size_t i = 0; i < depth_m.samples().size(); ++i)
        if (std::isnan(depth_m.samples()[i])) {  // padded, which costs a codec little
            depth_m.samples()[i] = std::numeric_limits<float>::infinity();
            std::ranges::fill(hidden.samples().subspan(4 * i, 4), 0.0f);
        }
    behind.channels.push_back({"hidden.Z", Imf::FLOAT, &depth_m, 0});
    parts.push_back(std::move(behind));
    return parts;
}

void write_part(Imf::MultiPartOutputFile& file, int number, const Part& part) {
    Imf::FrameBuffer buffer;
    std::vector<std::vector<half>> halves;
    for (const auto& [name, type, plane, channel] : part.channels) {
        const auto stride = std::size_t(plane->channels());
        if (type == Imf::FLOAT) {
            auto* first = const_cast<float*>(plane->samples().data()) + channel;  // which OpenEXR only reads
            buffer.insert(name, Imf::Slice(type, reinterpret_cast<char*>(first), sizeof(float) * stride,
                                           sizeof(float) * stride * std::size_t(plane->width())));
            continue;
        }
        std::vector<half>& values = halves.emplace_back();
        for (std::size_t i = std::size_t(channel); i < plane->samples().size(); i += stride)
            values.push_back(to_half(plane->samples()[i]));
        buffer.insert(name, Imf::Slice(type, reinterpret_cast<char*>(values.data()), sizeof(half),
                                       sizeof(half) * std::size_t(plane->width())));
    }
    Imf::OutputPart output(file, number);
    output.setFrameBuffer(buffer);
    output.writePixels(part.channels.front().plane->height());
}

/// What OpenEXR throws, as ours that names the file.
template <typename Write>
void writing(const fs::path& file, const Write& write) {
    try {
        AtomicStream stream(file);
        write(stream);
        stream.commit();
    } catch (const InputError&) {
        throw;
    } catch (const WorkError&) {
        throw;
    } catch (const std::exception& error) {
        throw WorkError(file.string() + ": " + error.what());
    }
}

}  // namespace

DeepCounts write_deep(const fs::path& file, const View& view) {
    DeepPixels pixels(view);
    writing(file, [&](AtomicStream& stream) {
        Imf::Header header = header_of(view);
        header.setType(Imf::DEEPSCANLINE);
        header.compression() = Imf::ZIPS_COMPRESSION;
        for (const char* name : half_names)
            header.channels().insert(name, Imf::Channel(Imf::HALF));
        for (const char* name : {"Z", "ZBack"})
            header.channels().insert(name, Imf::Channel(Imf::FLOAT));
        Imf::DeepScanLineOutputFile output(stream, header);
        pixels.write(output);
    });
    return pixels.counts();
}

void write_parts(const fs::path& file, const std::vector<View>& views) {
    std::vector<FloatImage> filled;
    filled.reserve(2 * views.size());  // parts borrow them
    std::vector<Part> parts;
    for (const View& view : views)
        for (Part& part : parts_of(view, views.size() > 1, filled))
            parts.push_back(std::move(part));
    std::vector<Imf::Header> headers;
    for (Part& part : parts) {
        for (const Part::Channel& channel : part.channels)
            part.header.channels().insert(channel.name, Imf::Channel(channel.type));
        headers.push_back(part.header);
    }
    writing(file, [&](AtomicStream& stream) {
        Imf::MultiPartOutputFile output(stream, headers.data(), int(headers.size()));
        for (std::size_t i = 0; i < parts.size(); ++i)
            write_part(output, int(i), parts[i]);
    });
}

}  // namespace equistream::compositing
