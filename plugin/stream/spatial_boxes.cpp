#include "spatial_boxes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <utility>

namespace equistream {

namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr LongitudeLatitudeRange front_half{-pi / 2, pi / 2, -pi / 2, pi / 2};

/// Flags of `stri`.
constexpr std::uint8_t has_left_eye = 1, has_right_eye = 2, eyes_reversed = 8;

constexpr std::size_t header_bytes = 8, version_bytes = 4;
/// What a video's sample entry has before its boxes, and a list of entries before the first one.
constexpr std::size_t entry_bytes = 78, entry_list_bytes = 8;

constexpr std::uint32_t name(const char (&letters)[5]) {
    std::uint32_t code = 0;
    for (int i = 0; i < 4; ++i)
        code = code << 8 | std::uint8_t(letters[i]);
    return code;
}

void put_u32(Bytes& out, std::uint32_t value) {
    for (int shift = 24; shift >= 0; shift -= 8)
        out.push_back(std::uint8_t(value >> shift));
}

Bytes box(std::uint32_t type, const Bytes& contents) {
    Bytes whole;
    put_u32(whole, std::uint32_t(header_bytes + contents.size()));
    put_u32(whole, type);
    whole.insert(whole.end(), contents.begin(), contents.end());
    return whole;
}

/// A box of one number, of version 0.
Bytes number_box(std::uint32_t type, std::uint32_t value) {
    Bytes contents;
    put_u32(contents, 0);
    put_u32(contents, value);
    return box(type, contents);
}

Bytes operator+(Bytes a, const Bytes& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

bool same_range(const LongitudeLatitudeRange& a, const LongitudeLatitudeRange& b) {
    const auto same = [](double x, double y) { return std::abs(x - y) < 1e-6; };
    return same(a.longitude_min, b.longitude_min) && same(a.longitude_max, b.longitude_max) &&
           same(a.latitude_min, b.latitude_min) && same(a.latitude_max, b.latitude_max);
}

/// One box of a file: where its contents are.
struct Place {
    std::uint32_t type = 0;
    std::uint64_t begin = 0, end = 0;
};

/// Walks boxes of a file. Whatever does not fit ends the walk.
class Walk {
public:
    explicit Walk(std::istream& file) : file_(file) {
        file_.seekg(0, std::ios::end);
        const auto size = file_.tellg();
        size_ = file_ && size > 0 ? std::uint64_t(size) : 0;
    }

    Place whole() const { return {0, 0, size_}; }

    /// Calls `take` with each box within `outer`, behind its first `skip` bytes, until it returns false.
    template <typename Take>
    void each(const Place& outer, std::uint64_t skip, const Take& take) {
        for (std::uint64_t at = outer.begin + skip; at + header_bytes <= outer.end && boxes_left_ > 0; --boxes_left_) {
            Place place;
            std::uint64_t size = u32(at);
            std::uint64_t header = header_bytes;
            place.type = u32(at + 4);
            if (size == 1) {
                header += 8;
                size = at + header <= outer.end ? std::uint64_t{u32(at + 8)} << 32 | u32(at + 12) : 0;
            } else if (size == 0) {
                size = outer.end - at;
            }
            if (!file_ || size < header || size > outer.end - at)
                return;
            place.begin = at + header;
            place.end = at + size;
            if (!take(place))
                return;
            at = place.end;
        }
    }

    /// The first of that type.
    std::optional<Place> find(const Place& outer, std::uint32_t type, std::uint64_t skip = 0) {
        std::optional<Place> found;
        each(outer, skip, [&](const Place& place) {
            if (place.type == type)
                found = place;
            return !found;
        });
        return found;
    }

    std::uint32_t u32(std::uint64_t at) {
        unsigned char bytes[4] = {};
        file_.seekg(std::streamoff(at));
        file_.read(reinterpret_cast<char*>(bytes), 4);
        return std::uint32_t(bytes[0]) << 24 | std::uint32_t(bytes[1]) << 16 | std::uint32_t(bytes[2]) << 8 | bytes[3];
    }

    /// What a box of one number holds, behind its version.
    std::optional<std::uint32_t> number(const std::optional<Place>& place) {
        if (!place || place->end - place->begin < version_bytes + 4)
            return std::nullopt;
        return u32(place->begin + version_bytes);
    }

    std::optional<std::uint8_t> byte(const std::optional<Place>& place) {
        if (!place || place->end - place->begin < version_bytes + 1)
            return std::nullopt;
        file_.seekg(std::streamoff(place->begin + version_bytes));
        const int value = file_.get();
        return value < 0 ? std::nullopt : std::optional(std::uint8_t(value));
    }

    bool good() const { return bool(file_); }

private:
    std::istream& file_;
    std::uint64_t size_ = 0;
    int boxes_left_ = 20'000;
};

std::optional<Place> find(Walk& walk, std::optional<Place> outer, std::uint32_t type) {
    return outer ? walk.find(*outer, type) : std::nullopt;
}

SpatialTags tags_of(Walk& walk, const Place& vexu) {
    SpatialTags tags;
    const auto projection = walk.number(find(walk, walk.find(vexu, name("proj")), name("prji")));
    if (projection == name("equi"))
        tags.sphere = LongitudeLatitudeRange{};
    else if (projection == name("hequ"))
        tags.sphere = front_half;
    const auto eyes = walk.find(vexu, name("eyes"));
    const auto packing = walk.number(find(walk, walk.find(vexu, name("pack")), name("pkin")));
    const std::uint8_t flags = walk.byte(find(walk, eyes, name("stri"))).value_or(has_left_eye | has_right_eye);
    if ((flags & has_left_eye) != 0 && (flags & has_right_eye) != 0) {
        tags.stereo = packing == name("side")   ? StereoPacking::side_by_side
                      : packing == name("over") ? StereoPacking::top_bottom
                                                : StereoPacking::none;
        tags.right_first = tags.stereo != StereoPacking::none && (flags & eyes_reversed) != 0;
    }
    if (const auto micrometres = walk.number(find(walk, find(walk, eyes, name("cams")), name("blin"))))
        tags.baseline_m = 1e-6 * *micrometres;
    return tags;
}

/// Of a trak: its number. Its header is of version 0 or 1, which has longer dates.
std::optional<std::uint32_t> track_number(Walk& walk, const Place& track) {
    const auto header = walk.find(track, name("tkhd"));
    if (!header || header->end - header->begin < 24)
        return std::nullopt;
    return walk.u32(header->begin + (walk.u32(header->begin) >> 24 == 1 ? 20 : 12));
}

}  // namespace

std::vector<std::uint8_t> vexu_box(const SpatialTags& tags) {
    Bytes contents;
    if (tags.stereo != StereoPacking::none) {
        Bytes indication(version_bytes, 0);
        indication.push_back(std::uint8_t(has_left_eye | has_right_eye | (tags.right_first ? eyes_reversed : 0)));
        Bytes eyes = box(name("stri"), indication);
        if (tags.baseline_m)
            eyes = std::move(eyes) +
                   box(name("cams"), number_box(name("blin"), std::uint32_t(std::lround(*tags.baseline_m * 1e6))));
        contents = box(name("eyes"), eyes);
    }
    if (tags.sphere && tags.sphere->is_full_sphere())
        contents = std::move(contents) + box(name("proj"), number_box(name("prji"), name("equi")));
    else if (tags.sphere && same_range(*tags.sphere, front_half))
        contents = std::move(contents) + box(name("proj"), number_box(name("prji"), name("hequ")));
    if (tags.stereo != StereoPacking::none)
        contents =
            std::move(contents) +
            box(name("pack"),
                number_box(name("pkin"), tags.stereo == StereoPacking::side_by_side ? name("side") : name("over")));
    return contents.empty() ? contents : box(name("vexu"), contents);
}

std::vector<std::uint8_t> with_box_in_first_entry(std::span<const std::uint8_t> header,
                                                  std::span<const std::uint8_t> more) {
    Bytes bytes(header.begin(), header.end());
    const auto u32 = [&](std::size_t at) {
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < 4; ++i)
            value = value << 8 | bytes[at + i];
        return value;
    };
    std::vector<std::size_t> grown;  // where the boxes around it begin
    std::size_t begin = 0, end = bytes.size();
    constexpr std::uint32_t any = 0;
    for (const std::uint32_t type :
         {name("moov"), name("trak"), name("mdia"), name("minf"), name("stbl"), name("stsd"), any}) {
        std::size_t at = begin;
        while (at + header_bytes <= end && type != any && u32(at + 4) != type && u32(at) >= header_bytes &&
               u32(at) <= end - at)
            at += u32(at);
        if (at + header_bytes > end || u32(at) < header_bytes || u32(at) > end - at)
            return bytes;
        grown.push_back(at);
        begin = at + header_bytes + (type == name("stsd") ? entry_list_bytes : 0);
        end = at + u32(at);
    }
    for (const std::size_t at : grown) {
        const auto size = std::uint32_t(u32(at) + more.size());
        for (std::size_t i = 0; i < 4; ++i)
            bytes[at + i] = std::uint8_t(size >> (24 - 8 * i));
    }
    bytes.insert(bytes.begin() + std::ptrdiff_t(end), more.begin(), more.end());
    return bytes;
}

std::map<std::uint32_t, SpatialTags> read_spatial_tags(std::istream& file) {
    std::map<std::uint32_t, SpatialTags> found;
    Walk walk(file);
    const auto movie = walk.find(walk.whole(), name("moov"));
    if (!movie)
        return found;
    walk.each(*movie, 0, [&](const Place& track) {
        if (track.type != name("trak"))
            return true;
        auto list = walk.find(track, name("mdia"));
        for (const std::uint32_t type : {name("minf"), name("stbl"), name("stsd")})
            list = find(walk, list, type);
        const auto number = track_number(walk, track);
        if (!list || !number)
            return true;
        walk.each(*list, entry_list_bytes, [&](const Place& entry) {
            if (const auto vexu = walk.find(entry, name("vexu"), entry_bytes))
                found.emplace(*number, tags_of(walk, *vexu));
            return true;
        });
        return true;
    });
    if (!walk.good())
        found.clear();
    return found;
}

bool is_in_fragments(std::istream& file) {
    Walk walk(file);
    return find(walk, walk.find(walk.whole(), name("moov")), name("mvex")) && walk.good();
}

}  // namespace equistream
