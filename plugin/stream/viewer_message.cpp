#include <equistream/camera_limits.h>
#include <equistream/viewer_message.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

namespace equistream {

namespace {

static_assert(std::endian::native == std::endian::little, "fields are copied as they lie in memory");

constexpr std::array<std::uint8_t, 4> magic = {'E', 'Q', 'V', 'M'};
constexpr std::uint16_t version = 1;
constexpr std::uint16_t pose_kind = 1;
constexpr std::uint32_t longest_body = 4096;

struct Header {
    std::array<std::uint8_t, 4> magic = equistream::magic;
    std::uint16_t version = equistream::version;
    std::uint16_t kind = pose_kind;
    std::uint32_t body_bytes = 0;
};
static_assert(sizeof(Header) == 12);

using PoseBody = std::array<double, 8>;
static_assert(sizeof(PoseBody) == 64);
using ViewBody = std::array<double, 2>;  ///< appended to a pose, or not
using SteersBody = double;               ///< appended to both where it is 0: the head has only turned

/// Of a view's tangents: about 1 and 178 degrees.
constexpr double narrowest_view = 0.01, widest_view = 57;

constexpr double longest_off_unit = 1e-6;

/// Eyes are beside the head, and must lie within the limit too.
constexpr double max_head_coordinate_m = max_coordinate_m - max_ipd_m;

bool leaves_room_for_eyes(const glm::dvec3& head_m) {
    return glm::all(glm::lessThanEqual(glm::abs(head_m), glm::dvec3(max_head_coordinate_m)));
}

std::optional<ViewExtent> extent_of(const ViewBody& body) {
    if (std::ranges::all_of(body, [](double half) { return half >= narrowest_view && half <= widest_view; }))
        return ViewExtent{body[0], body[1]};
    return std::nullopt;
}

/// Of a body that is as long as a pose's at least.
std::optional<ViewerPose> pose_of(std::span<const std::uint8_t> bytes) {
    PoseBody body;
    std::memcpy(&body, bytes.data(), sizeof body);
    ViewBody view = {0, 0};
    if (bytes.size() >= sizeof body + sizeof view)
        std::memcpy(&view, bytes.data() + sizeof body, sizeof view);
    SteersBody steers = 1;
    if (bytes.size() >= sizeof body + sizeof view + sizeof steers)
        std::memcpy(&steers, bytes.data() + sizeof body + sizeof view, sizeof steers);
    const Pose head{{body[1], body[2], body[3]}, {body[4], body[5], body[6], body[7]}};
    const bool finite = std::ranges::all_of(body, [](double value) { return std::isfinite(value); });
    if (!finite || !leaves_room_for_eyes(head.position_m) ||
        !(std::abs(glm::length(head.orientation) - 1) <= longest_off_unit))
        return std::nullopt;
    return ViewerPose{body[0], head, extent_of(view), steers != 0};
}

}  // namespace

std::vector<std::uint8_t> encode_viewer_pose(const ViewerPose& pose) {
    const glm::dvec3& p = pose.head.position_m;
    const glm::dquat& q = pose.head.orientation;
    const PoseBody body = {pose.time_s, p.x, p.y, p.z, q.w, q.x, q.y, q.z};
    ViewBody view = {0, 0};  // which counts as not said
    if (pose.view)
        view = {pose.view->half_width, pose.view->half_height};
    const SteersBody steers = 0;
    std::vector<std::uint8_t> bytes(sizeof(Header) + sizeof body + sizeof view + sizeof steers);
    std::memcpy(bytes.data() + sizeof(Header), &body, sizeof body);
    std::memcpy(bytes.data() + sizeof(Header) + sizeof body, &view, sizeof view);
    std::memcpy(bytes.data() + sizeof(Header) + sizeof body + sizeof view, &steers, sizeof steers);
    const std::size_t unsaid = !pose.steers ? 0 : pose.view ? sizeof steers : sizeof steers + sizeof view;
    bytes.resize(bytes.size() - unsaid);
    Header header;
    header.body_bytes = std::uint32_t(bytes.size() - sizeof header);
    std::memcpy(bytes.data(), &header, sizeof header);
    return bytes;
}

/// Drops what cannot begin a message. True: a header is there.
bool ViewerMessageReader::at_message() {
    for (;;) {
        const auto begin = std::search(read_.begin(), read_.end(), magic.begin(), magic.end());
        if (begin == read_.end()) {  // of the magic's beginning the rest may come
            read_.erase(read_.begin(), read_.end() - std::min<std::ptrdiff_t>(std::ssize(read_), magic.size() - 1));
            return false;
        }
        read_.erase(read_.begin(), begin);
        if (read_.size() < sizeof(Header))
            return false;
        Header header;
        std::memcpy(&header, read_.data(), sizeof header);
        if (header.body_bytes <= longest_body)
            return true;
        read_.erase(read_.begin());  // no message of ours is so long
    }
}

std::optional<ViewerPose> ViewerMessageReader::take(std::span<const std::uint8_t> bytes) {
    std::optional<ViewerPose> last;
    read_.insert(read_.end(), bytes.begin(), bytes.end());
    while (at_message()) {
        Header header;
        std::memcpy(&header, read_.data(), sizeof header);
        if (read_.size() < sizeof header + header.body_bytes)
            break;
        if (header.version == version && header.kind == pose_kind && header.body_bytes >= sizeof(PoseBody))
            if (const auto pose = pose_of(std::span(read_).subspan(sizeof header, header.body_bytes)))
                last = pose;
        read_.erase(read_.begin(), read_.begin() + std::ptrdiff_t(sizeof header + header.body_bytes));
    }
    return last;
}

}  // namespace equistream
