#include "exr_attributes.h"
#include "exr_session.h"
#include "parallel.h"

#include <equistream/aov.h>
#include <equistream/error.h>
#include <equistream/sequence.h>

#include <algorithm>
#include <cassert>
#include <cstring>

namespace equistream {
namespace {

constexpr int max_parts = 16;
constexpr int max_channels = 256;
/// Deflate cannot do better than 1032:1, so a file whose planes need more than this is not whole.
constexpr std::int64_t max_ratio = 1100;

/// Where one EXR channel goes.
struct ChannelTarget {
    std::string name;
    void* data = nullptr;  ///< first sample of the top row
    bool is_id = false;
    int channels = 0;  ///< of the plane: samples from one pixel to the next
    int width = 0;
};

const exr_attr_chlist_t& channel_list(const ExrSession& session, int part) {
    const exr_attr_chlist_t* channels = nullptr;
    session.check(exr_get_channels(session.context(), part, &channels), "channels");
    if (channels->num_channels < 1 || channels->num_channels > max_channels)
        session.refuse("1 to " + std::to_string(max_channels) + " channels", std::to_string(channels->num_channels));
    return *channels;
}

int part_count(const ExrSession& session) {
    int count = 0;
    session.check(exr_get_count(session.context(), &count), "parts");
    if (count < 1 || count > max_parts)
        session.refuse("1 to " + std::to_string(max_parts) + " parts", std::to_string(count));
    return count;
}

struct Extent {
    int width = 0;
    int height = 0;
    int top = 0;
};

Extent extent_of(const ExrSession& session, int part) {
    exr_attr_box2i_t window{}, shown{};
    session.check(exr_get_data_window(session.context(), part, &window), "size");
    session.check(exr_get_display_window(session.context(), part, &shown), "size");
    if (window.min.x != shown.min.x || window.min.y != shown.min.y || window.max.x != shown.max.x ||
        window.max.y != shown.max.y)
        session.refuse("pixels of the whole picture", "a part of it (its data window is not its display window); "
                                                      "equistream import reads such files");
    const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
    const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
    if (width < 1 || height < 1 || width > max_image_side || height > max_image_side ||
        width * height > max_image_pixels)
        session.refuse("at most " + std::to_string(max_image_side) + " pixels a side and " +
                           std::to_string(max_image_pixels) + " in all",
                       std::to_string(width) + "x" + std::to_string(height));
    return {static_cast<int>(width), static_cast<int>(height), window.min.y};
}

/// Scan lines with lossless, simple compression only: the rest of OpenEXR 3.1.5 is not for untrusted files.
void check_coding(const ExrSession& session, int part) {
    exr_storage_t storage{};
    exr_compression_t compression{};
    session.check(exr_get_storage(session.context(), part, &storage), "storage");
    session.check(exr_get_compression(session.context(), part, &compression), "compression");
    if (storage != EXR_STORAGE_SCANLINE)
        session.refuse("scan lines", "tiles or deep data");
    if (compression > EXR_COMPRESSION_ZIP)
        session.refuse("NONE, RLE, ZIPS or ZIP compression", "compression " + std::to_string(compression));
    std::int64_t pixel_bytes = 0;
    const exr_attr_chlist_t& channels = channel_list(session, part);
    for (int i = 0; i < channels.num_channels; ++i) {
        if (channels.entries[i].x_sampling != 1 || channels.entries[i].y_sampling != 1)
            session.refuse("channels without subsampling", channels.entries[i].name.str);
        pixel_bytes += channels.entries[i].pixel_type == EXR_PIXEL_HALF ? 2 : 4;
    }
    const Extent extent = extent_of(session, part);
    if (pixel_bytes * extent.width * extent.height / max_ratio > session.size_bytes())
        session.refuse("a whole EXR frame",
                       std::to_string(session.size_bytes()) + " bytes for " + size_text(extent.width, extent.height));
}

const exr_attr_chlist_entry_t* find_channel(const ExrSession& session, int part, std::string_view name) {
    const exr_attr_chlist_t& channels = channel_list(session, part);
    for (int i = 0; i < channels.num_channels; ++i)
        if (name == channels.entries[i].name.str)
            return &channels.entries[i];
    return nullptr;
}

/// The part that holds a plane: all its channels, where alpha alone may be absent. -1: none does.
int part_with(const ExrSession& session, const AovInfo& aov) {
    const int parts = part_count(session);
    for (int part = 0; part < parts; ++part) {
        bool all = true;
        for (const std::string_view name : aov.channels)
            all = all && (name == "A" || find_channel(session, part, name) != nullptr);
        if (all)
            return part;
    }
    return -1;
}

std::vector<AovInfo> planes_to_read(const ExrSession& session, const std::vector<std::string>& wanted) {
    std::vector<AovInfo> present;
    std::vector<std::string_view> names;
    for (const AovInfo& aov : aov_catalogue())
        if (part_with(session, aov) >= 0) {
            present.push_back(aov);
            names.push_back(aov.name);
        }
    if (wanted.empty()) {
        if (present.empty())
            session.refuse("at least one plane of the AOV catalogue", "none");
        return present;
    }
    std::vector<AovInfo> chosen;
    for (const std::string& name : wanted) {
        const auto found = std::ranges::find(present, name, &AovInfo::name);
        if (found == present.end())
            session.refuse("plane " + name, names.empty() ? "no plane at all" : in_a_sentence(names, ", "));
        if (std::ranges::find(chosen, name, &AovInfo::name) == chosen.end())
            chosen.push_back(*found);
    }
    return chosen;
}

void add_targets(const ExrSession& session, const AovInfo& aov, Frame& frame, const Extent& extent,
                 std::vector<ChannelTarget>& targets) {
    const int part = part_with(session, aov);
    const int channels = static_cast<int>(aov.channels.size());
    const bool is_id = aov.type == SampleType::id;
    const std::string plane(aov.name);
    // A file without alpha is opaque.
    const float fill = aov.name == "colour" ? 1.0f : 0.0f;
    if (is_id)
        frame.ids[plane] = IdImage(extent.width, extent.height, channels);
    else
        frame.planes[plane] = FloatImage(extent.width, extent.height, channels, fill);
    for (int c = 0; c < channels; ++c) {
        const std::string_view name = aov.channels[static_cast<std::size_t>(c)];
        const exr_attr_chlist_entry_t* entry = find_channel(session, part, name);
        if (entry == nullptr)
            continue;
        if ((entry->pixel_type == EXR_PIXEL_UINT) != is_id)
            session.refuse(std::string(name) + (is_id ? " as uint" : " as half or float"), "another type");
        void* data = is_id ? static_cast<void*>(frame.ids[plane].samples().data() + c)
                           : static_cast<void*>(frame.planes[plane].samples().data() + c);
        targets.push_back({std::string(name), data, is_id, channels, extent.width});
    }
}

/// Where the rows from `row` on are in the file; refuses the file where it ends before they do.
exr_chunk_info_t find_chunk(const ExrSession& session, int part, const Extent& extent, int row) {
    exr_chunk_info_t chunk{};
    session.check(exr_read_scanline_chunk_info(session.context(), part, extent.top + row, &chunk), "finding pixels");
    const auto bytes = static_cast<std::uint64_t>(session.size_bytes());
    if (chunk.width != extent.width || chunk.start_y - extent.top != row || row + chunk.height > extent.height ||
        chunk.packed_size > bytes || chunk.data_offset > bytes - chunk.packed_size)
        session.refuse("a whole EXR frame", "a chunk that does not fit");
    return chunk;
}

std::int32_t rows_of_chunk(const ExrSession& session, int part) {
    std::int32_t rows = 0;
    session.check(exr_get_scanlines_per_chunk(session.context(), part, &rows), "chunks");
    assert(rows > 0);
    return rows;
}

class ChunkDecoder {
public:
    ChunkDecoder(const ExrSession& session, int part, const std::vector<ChannelTarget>& targets)
        : session_(session), part_(part), targets_(targets) {}
    ~ChunkDecoder() {
        if (initialised_)
            exr_decoding_destroy(session_.context(), &pipeline_);
    }
    ChunkDecoder(const ChunkDecoder&) = delete;
    ChunkDecoder& operator=(const ChunkDecoder&) = delete;

    void decode(const Extent& extent, int row) {
        exr_context_t context = session_.context();
        const exr_chunk_info_t chunk = find_chunk(session_, part_, extent, row);
        session_.check(initialised_ ? exr_decoding_update(context, part_, &chunk, &pipeline_)
                                    : exr_decoding_initialize(context, part_, &chunk, &pipeline_),
                       "preparing to read");
        initialised_ = true;
        scratch_.resize(static_cast<std::size_t>(pipeline_.channel_count) * static_cast<std::size_t>(extent.width) *
                        static_cast<std::size_t>(chunk.height));
        for (int i = 0; i < pipeline_.channel_count; ++i)
            connect(pipeline_.channels[i], scratch_of(i, extent.width, chunk.height));
        session_.check(exr_decoding_choose_default_routines(context, part_, &pipeline_), "preparing to read");
        session_.check(exr_decoding_run(context, part_, &pipeline_), "reading pixels");
        for (int i = 0; i < pipeline_.channel_count; ++i)
            if (const ChannelTarget* target = target_of(pipeline_.channels[i]))
                interleave(scratch_of(i, extent.width, chunk.height), *target, row, chunk.height);
    }

private:
    const ChannelTarget* target_of(const exr_coding_channel_info_t& source) const {
        const auto target = std::ranges::find(targets_, std::string_view(source.channel_name), &ChannelTarget::name);
        return target == targets_.end() ? nullptr : &*target;
    }

    std::uint32_t* scratch_of(int channel, int width, int rows) {
        return scratch_.data() + static_cast<std::ptrdiff_t>(channel) * width * rows;
    }

    /// Every channel, wanted or not, into a plane of its own: OpenEXRCore 3.1.5 reverses the channels when it
    /// interleaves three or four halfs to floats itself.
    static void connect(exr_coding_channel_info_t& source, std::uint32_t* plane) {
        source.user_bytes_per_element = 4;
        source.user_data_type = source.data_type == EXR_PIXEL_UINT ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
        source.user_pixel_stride = 4;
        source.user_line_stride = 4 * source.width;
        source.decode_to_ptr = reinterpret_cast<std::uint8_t*>(plane);
    }

    static void interleave(const std::uint32_t* plane, const ChannelTarget& target, int first_row, int rows) {
        const std::ptrdiff_t row_samples = static_cast<std::ptrdiff_t>(target.channels) * target.width;
        auto* out = static_cast<std::uint8_t*>(target.data) + 4 * row_samples * first_row;
        for (std::ptrdiff_t i = 0; i < static_cast<std::ptrdiff_t>(target.width) * rows; ++i)
            std::memcpy(out + 4 * i * target.channels, plane + i, 4);
    }

    const ExrSession& session_;
    int part_;
    const std::vector<ChannelTarget>& targets_;
    bool initialised_ = false;
    std::vector<std::uint32_t> scratch_;
    exr_decode_pipeline_t pipeline_ = EXR_DECODE_PIPELINE_INITIALIZER;
};

void read_part(const ExrSession& session, int part, const Extent& extent, const std::vector<ChannelTarget>& targets) {
    const std::int32_t rows_per_chunk = rows_of_chunk(session, part);
    const int chunk_count = (extent.height + rows_per_chunk - 1) / rows_per_chunk;
    for_each_index(
        chunk_count, [&] { return std::make_unique<ChunkDecoder>(session, part, targets); },
        [&](std::unique_ptr<ChunkDecoder>& decoder, int i) { decoder->decode(extent, i * rows_per_chunk); });
}

/// Checks every part that may be read and returns their common size.
Extent checked_extent(const ExrSession& session) {
    const Extent first = extent_of(session, 0);
    const int parts = part_count(session);
    for (int part = 0; part < parts; ++part) {
        check_coding(session, part);
        const Extent extent = extent_of(session, part);
        if (extent.width != first.width || extent.height != first.height)
            session.refuse("parts of one size",
                           size_text(extent.width, extent.height) + " besides " + size_text(first.width, first.height));
    }
    return first;
}

}  // namespace

Frame read_exr(const std::filesystem::path& file, const std::vector<std::string>& planes) {
    const ExrSession session = ExrSession::for_reading(file);
    const Extent extent = checked_extent(session);
    Frame frame;
    if (has_attributes(session))
        frame.info = read_attributes(session, extent.width, extent.height);
    else
        frame.info.camera = EquirectCamera{extent.width, extent.height, {}};
    const std::vector<AovInfo> chosen = planes_to_read(session, planes);
    const int parts = part_count(session);
    for (int part = 0; part < parts; ++part) {
        std::vector<ChannelTarget> targets;
        for (const AovInfo& aov : chosen)
            if (part_with(session, aov) == part)
                add_targets(session, aov, frame, extent, targets);
        if (!targets.empty())
            read_part(session, part, extent_of(session, part), targets);
    }
    return frame;
}

void require_whole_exr(const std::filesystem::path& file) {
    const ExrSession session = ExrSession::for_reading(file);
    checked_extent(session);
    const int parts = part_count(session);
    for (int part = 0; part < parts; ++part) {
        const Extent extent = extent_of(session, part);
        const std::int32_t rows_per_chunk = rows_of_chunk(session, part);
        for (int row = 0; row < extent.height; row += rows_per_chunk)
            find_chunk(session, part, extent, row);
    }
}

void check_exr_pixels(const std::filesystem::path& file) {
    const ExrSession session = ExrSession::for_reading(file);
    checked_extent(session);
    const int parts = part_count(session);
    for (int part = 0; part < parts; ++part)
        read_part(session, part, extent_of(session, part), {});
}

FrameInfo read_exr_info(const std::filesystem::path& file) {
    const ExrSession session = ExrSession::for_reading(file);
    const Extent extent = checked_extent(session);
    return read_attributes(session, extent.width, extent.height);
}

}  // namespace equistream
