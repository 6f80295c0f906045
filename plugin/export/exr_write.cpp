#include "exr_attributes.h"
#include "exr_session.h"
#include "parallel.h"

#include <equistream/aov.h>
#include <equistream/error.h>
#include <equistream/sequence.h>

#include <Imath/half.h>

#include <algorithm>
#include <cmath>

namespace equistream {
namespace {

constexpr int rows_per_chunk = 16;  // what EXR's ZIP compression means
constexpr float max_half = 65504;

/// Where the samples of one EXR channel lie. Exactly one of the pointers is set.
struct ChannelSource {
    std::string name;
    SampleType type = SampleType::real;
    bool is_colour = false;
    const float* real = nullptr;
    const std::uint32_t* id = nullptr;
    std::ptrdiff_t pixel_stride = 0;
    std::ptrdiff_t row_stride = 0;
};

struct Part {
    const char* name = nullptr;
    std::vector<ChannelSource> channels;
};

exr_pixel_type_t exr_type(SampleType type) {
    return type == SampleType::half ? EXR_PIXEL_HALF : type == SampleType::id ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
}

template <typename T>
void check_shape(const AovInfo& aov, const Image<T>& image, const FrameInfo& info) {
    if (image.width() != picture_width(info) || image.height() != picture_height(info) ||
        image.channels() != static_cast<int>(aov.channels.size()))
        throw InputError(
            expected_found("plane " + std::string(aov.name),
                           size_text(picture_width(info), picture_height(info)) + " with " +
                               std::to_string(aov.channels.size()) + " channels",
                           size_text(image.width(), image.height()) + " with " + std::to_string(image.channels())));
}

/// Appends the channels of one plane, if the frame has it.
void append_channels(const Frame& frame, const AovInfo& aov, std::vector<ChannelSource>& channels) {
    const auto real = frame.planes.find(aov.name);
    const auto id = frame.ids.find(aov.name);
    const bool is_id = aov.type == SampleType::id;
    if (is_id ? id == frame.ids.end() : real == frame.planes.end())
        return;
    if (is_id)
        check_shape(aov, id->second, frame.info);
    else
        check_shape(aov, real->second, frame.info);
    for (std::size_t c = 0; c < aov.channels.size(); ++c) {
        ChannelSource source;
        source.name = aov.channels[c];
        source.type = aov.type;
        source.is_colour = aov.unit == "radiance";
        if (is_id)
            source.id = id->second.samples().data() + c;
        else
            source.real = real->second.samples().data() + c;
        source.pixel_stride = static_cast<std::ptrdiff_t>(aov.channels.size());
        source.row_stride = source.pixel_stride * picture_width(frame.info);
        channels.push_back(source);
    }
}

void refuse_unknown_planes(const Frame& frame) {
    const auto check = [](const std::string& name, bool is_id) {
        const auto aov = find_aov(name);
        if (!aov || (aov->type == SampleType::id) != is_id)
            throw InputError(expected_found("frame", "planes of the AOV catalogue", "\"" + name + "\""));
    };
    for (const auto& [name, image] : frame.planes)
        check(name, false);
    for (const auto& [name, image] : frame.ids)
        check(name, true);
}

std::vector<Part> make_parts(const Frame& frame, const ExrWriteOptions& options) {
    refuse_unknown_planes(frame);
    Part rgba{"rgba", {}};
    Part data{"data", {}};
    for (const AovInfo& aov : aov_catalogue())
        append_channels(frame, aov, aov.data_part && !options.single_part ? data.channels : rgba.channels);
    const auto depth = std::ranges::find(rgba.channels, "depth.Z", &ChannelSource::name);
    if (options.single_part && depth != rgba.channels.end()) {
        ChannelSource plain = *depth;
        plain.name = "Z";
        rgba.channels.push_back(plain);
    }
    std::vector<Part> parts;
    for (Part* part : {&rgba, &data})
        if (!part->channels.empty())
            parts.push_back(std::move(*part));
    if (parts.empty())
        throw InputError(expected_found("frame", "at least one plane", "none"));
    return parts;
}

void write_header(const ExrSession& session, const std::vector<Part>& parts, const FrameInfo& info,
                  const ExrWriteOptions& options) {
    exr_context_t context = session.context();
    for (const Part& part : parts) {
        int index = 0;
        session.check(exr_add_part(context, part.name, EXR_STORAGE_SCANLINE, &index), "adding a part");
        session.check(exr_initialize_required_attr_simple(context, index, picture_width(info), picture_height(info),
                                                          EXR_COMPRESSION_ZIP),
                      "setting the size");
        for (const ChannelSource& channel : part.channels)
            session.check(exr_add_channel(context, index, channel.name.c_str(), exr_type(channel.type),
                                          EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1),
                          "adding a channel");
        write_attributes(session, index, info);
        if (options.left_out_samples > 0)
            write_left_out_samples(session, index, options.left_out_samples);
        for (const auto& [name, text] : options.texts)
            AttributeWriter(session, index).text(name.c_str(), text);
    }
    session.check(exr_write_header(context), "writing the header");
}

/// Per-thread state that turns sixteen rows of one part into a compressed chunk.
class ChunkEncoder {
public:
    ChunkEncoder(const ExrSession& session, const Part& part, int part_index, const FrameInfo& info)
        : session_(session), part_(part), part_index_(part_index), width_(picture_width(info)),
          height_(picture_height(info)) {}
    ~ChunkEncoder() {
        if (initialised_)
            exr_encoding_destroy(session_.context(), &pipeline_);
    }
    ChunkEncoder(const ChunkEncoder&) = delete;
    ChunkEncoder& operator=(const ChunkEncoder&) = delete;

    /// Returns the number of colour pixels that were not finite.
    std::int64_t encode(int first_row, std::vector<std::uint8_t>& out) {
        exr_chunk_info_t chunk{};
        session_.check(exr_write_scanline_chunk_info(session_.context(), part_index_, first_row, &chunk), "a chunk");
        start(chunk);
        halves_.clear();
        halves_.reserve(static_cast<std::size_t>(width_) * rows_per_chunk * part_.channels.size());
        for (int i = 0; i < pipeline_.channel_count; ++i)
            connect(pipeline_.channels[i], first_row);
        session_.check(exr_encoding_choose_default_routines(session_.context(), part_index_, &pipeline_), "packing");
        pipeline_.encoding_user_data = this;
        pipeline_.compress_fn = compress_packed;
        pipeline_.yield_until_ready_fn = keep_for_later;
        pipeline_.write_fn = keep_for_later;
        out_ = &out;
        session_.check(exr_encoding_run(session_.context(), part_index_, &pipeline_), "compressing");
        return count_bad_pixels(first_row, chunk.height);
    }

private:
    void start(const exr_chunk_info_t& chunk) {
        session_.check(initialised_ ? exr_encoding_update(session_.context(), part_index_, &chunk, &pipeline_)
                                    : exr_encoding_initialize(session_.context(), part_index_, &chunk, &pipeline_),
                       "preparing a chunk");
        initialised_ = true;
    }

    void connect(exr_coding_channel_info_t& target, int first_row) {
        const auto source =
            std::ranges::find(part_.channels, std::string_view(target.channel_name), &ChannelSource::name);
        assert(source != part_.channels.end());
        if (source->type == SampleType::half) {
            target.encode_from_ptr = reinterpret_cast<const std::uint8_t*>(to_halves(*source, first_row));
            target.user_pixel_stride = sizeof(Imath::half);
            target.user_line_stride = static_cast<std::int32_t>(sizeof(Imath::half)) * width_;
            return;
        }
        const std::ptrdiff_t offset = first_row * source->row_stride;
        target.encode_from_ptr = source->type == SampleType::id
                                     ? reinterpret_cast<const std::uint8_t*>(source->id + offset)
                                     : reinterpret_cast<const std::uint8_t*>(source->real + offset);
        target.user_pixel_stride = static_cast<std::int32_t>(source->pixel_stride * 4);
        target.user_line_stride = static_cast<std::int32_t>(source->row_stride * 4);
    }

    /// NaN becomes 0, values beyond the half range its ends. The pointer stays valid: halves_ was reserved.
    const Imath::half* to_halves(const ChannelSource& source, int first_row) {
        const std::size_t begin = halves_.size();
        for (int y = first_row; y < std::min(first_row + rows_per_chunk, height_); ++y) {
            const float* sample = source.real + y * source.row_stride;
            for (int x = 0; x < width_; ++x, sample += source.pixel_stride) {
                const float value = std::isnan(*sample) ? 0.0f : *sample;
                halves_.emplace_back(std::min(std::max(value, -max_half), max_half));
            }
        }
        return halves_.data() + begin;
    }

    std::int64_t count_bad_pixels(int first_row, int rows) const {
        const auto red = std::ranges::find(part_.channels, true, &ChannelSource::is_colour);
        if (red == part_.channels.end())
            return 0;
        std::int64_t bad = 0;
        for (int y = first_row; y < first_row + rows; ++y)
            for (int x = 0; x < width_; ++x) {
                const float* p = red->real + y * red->row_stride + x * red->pixel_stride;
                bad += !std::all_of(p, p + red->pixel_stride, [](float value) { return std::isfinite(value); });
            }
        return bad;
    }

    static exr_result_t compress_packed(exr_encode_pipeline_t* pipeline) {
        auto& self = *static_cast<ChunkEncoder*>(pipeline->encoding_user_data);
        try {
            self.compressor_.compress({static_cast<const std::uint8_t*>(pipeline->packed_buffer),
                                       static_cast<std::size_t>(pipeline->packed_bytes)},
                                      *self.out_);
            return EXR_ERR_SUCCESS;
        } catch (const std::bad_alloc&) {
            return EXR_ERR_OUT_OF_MEMORY;
        }
    }
    /// Chunks must be written in order; that is done afterwards, on one thread.
    static exr_result_t keep_for_later(exr_encode_pipeline_t*) { return EXR_ERR_SUCCESS; }

    const ExrSession& session_;
    const Part& part_;
    int part_index_;
    int width_;
    int height_;
    bool initialised_ = false;
    exr_encode_pipeline_t pipeline_ = EXR_ENCODE_PIPELINE_INITIALIZER;
    ZipCompressor compressor_;
    std::vector<Imath::half> halves_;
    std::vector<std::uint8_t>* out_ = nullptr;
};

std::int64_t write_part(const ExrSession& session, const Part& part, int part_index, const FrameInfo& info) {
    const int chunk_count = (picture_height(info) + rows_per_chunk - 1) / rows_per_chunk;
    std::vector<std::vector<std::uint8_t>> chunks(static_cast<std::size_t>(chunk_count));
    std::atomic<std::int64_t> bad_pixels{0};
    for_each_index(
        chunk_count, [&] { return std::make_unique<ChunkEncoder>(session, part, part_index, info); },
        [&](std::unique_ptr<ChunkEncoder>& encoder, int i) {
            bad_pixels += encoder->encode(i * rows_per_chunk, chunks[static_cast<std::size_t>(i)]);
        });
    for (int i = 0; i < chunk_count; ++i) {
        const auto& chunk = chunks[static_cast<std::size_t>(i)];
        session.check(
            exr_write_scanline_chunk(session.context(), part_index, i * rows_per_chunk, chunk.data(), chunk.size()),
            "writing pixels");
    }
    return bad_pixels;
}

}  // namespace

void require_plane_values(const AovInfo& aov, ImageView<const float> plane) {
    if (aov.unit == "radiance")
        return;
    const bool is_depth = aov.name == "depth" || aov.name == "virtual_depth";
    for (int y = 0; y < plane.height; ++y) {
        const float* row = plane.row(y);
        for (int i = 0; i < plane.width * plane.channels; ++i)
            if (!(is_depth ? row[i] >= 0 : std::isfinite(row[i])))
                throw InputError(expected_found("plane " + std::string(aov.name) + " at pixel " +
                                                    std::to_string(i / plane.channels) + "," + std::to_string(y),
                                                is_depth ? "a distance, +inf for a miss" : "a finite number",
                                                std::to_string(row[i])));
    }
}

std::int64_t write_exr(const std::filesystem::path& file, const Frame& frame, const ExrWriteOptions& options) {
    const std::vector<Part> parts = make_parts(frame, options);
    AtomicFile aside(file);
    std::int64_t bad_pixels = 0;
    {
        const ExrSession session = ExrSession::for_writing(file, aside);
        write_header(session, parts, frame.info, options);
        for (std::size_t i = 0; i < parts.size(); ++i)
            bad_pixels += write_part(session, parts[i], static_cast<int>(i), frame.info);
    }
    aside.commit(options.before_it_appears);
    return bad_pixels;
}

}  // namespace equistream
