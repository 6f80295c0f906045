#include "source.h"

#include <equistream/error.h>
#include <equistream/send_times.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <string_view>
#include <utility>

namespace equistream {

namespace {

/// Later times are taken for this one, some three years.
constexpr double latest_time_s = 1e8;

struct Placed {
    std::int64_t start;
    double time_s;
    double decoded_s;
    int stream;
    bool is_key;
};

double frame_duration_s(const AVFormatContext& format) {
    for (unsigned i = 0; i < format.nb_streams; ++i)
        if (const AVRational rate = format.streams[i]->avg_frame_rate; rate.num > 0 && rate.den > 0)
            return 1 / av_q2d(rate);
    return 1.0 / 30;
}

std::vector<Placed> read_packets(AVFormatContext& format) {
    std::vector<Placed> packets;
    const av::Packet packet = av::make_packet();
    while (av::read_packet(format, *packet) >= 0) {
        const std::int64_t time = packet->pts != AV_NOPTS_VALUE ? packet->pts : packet->dts;
        const std::int64_t decoded = packet->dts != AV_NOPTS_VALUE ? packet->dts : time;
        const double tick_s = av_q2d(format.streams[packet->stream_index]->time_base);
        if (packet->pos >= 0 && time != AV_NOPTS_VALUE)
            packets.push_back({packet->pos, double(time) * tick_s, double(decoded) * tick_s, packet->stream_index,
                               (packet->flags & AV_PKT_FLAG_KEY) != 0});
        av_packet_unref(packet.get());
    }
    return packets;
}

/// From the first to the last picture of one track: in an mp4 they begin at times of their own.
double longest_track_s(const std::vector<Placed>& packets) {
    std::map<int, std::pair<double, double>> ends_s;
    double longest_s = 0;
    for (const Placed& packet : packets) {
        auto& [first_s, last_s] = ends_s.try_emplace(packet.stream, packet.time_s, packet.time_s).first->second;
        first_s = std::min(first_s, packet.time_s);
        last_s = std::max(last_s, packet.time_s);
        longest_s = std::max(longest_s, last_s - first_s);
    }
    return longest_s;
}

/// `packets` by their places in the file.
std::vector<Moment> moments_of(const std::vector<Placed>& packets, double first_s) {
    std::map<int, double> earliest_s;  // of a track's packets so far, from the back
    std::set<int> unready;             // tracks that cannot be decoded from here on
    std::vector<Moment> moments;
    double due_s = latest_time_s;
    for (std::size_t i = packets.size(); i-- > 1;) {
        const Placed& packet = packets[i];
        due_s = std::min(due_s, packet.time_s - first_s);
        double& earliest = earliest_s.try_emplace(packet.stream, packet.time_s).first->second;
        earliest = std::min(earliest, packet.time_s);
        // Of an open group, pictures behind the key frame are shown before it, and need what comes before.
        if (packet.is_key && packet.time_s <= earliest)
            unready.erase(packet.stream);
        else
            unready.insert(packet.stream);
        if (packets[i - 1].time_s != packet.time_s)
            moments.push_back({packets[i - 1].start, packet.start, due_s, unready.empty()});
    }
    std::ranges::reverse(moments);
    return moments;
}

std::vector<DuePacket> due_as_decoded(std::vector<Placed> packets) {
    std::map<int, double> first_s;  // of each track: in an mp4 they begin at times of their own
    for (const Placed& packet : packets) {
        double& first = first_s.try_emplace(packet.stream, packet.time_s).first->second;
        first = std::min(first, packet.time_s);
    }
    for (Placed& packet : packets) {
        packet.time_s -= first_s.at(packet.stream);
        packet.decoded_s -= first_s.at(packet.stream);
    }
    std::ranges::stable_sort(packets, {}, &Placed::decoded_s);
    std::vector<DuePacket> due;
    double due_s = latest_time_s;
    for (auto packet = packets.rbegin(); packet != packets.rend(); ++packet) {
        due_s = std::min(due_s, packet->time_s);
        due.push_back({packet->start, due_s});
    }
    std::ranges::sort(due, {}, &DuePacket::start);
    return due;
}

}  // namespace

const Moment* newest_group(const std::vector<Moment>& moments, double by_s) {
    auto later = std::ranges::upper_bound(moments, by_s, {}, &Moment::time_s);
    while (later != moments.begin())
        if ((--later)->begins_group)
            return &*later;
    return nullptr;
}

SendTimes read_send_times(const std::string& file, const std::function<bool()>& interrupted) {
    StreamReadOptions options;
    options.interrupted = interrupted;
    const Source format(file, options);
    std::vector<Placed> packets = read_packets(*format.get());
    if (packets.empty())
        throw InputError(expected_found(file, "video packets with times and byte positions", "none"));
    std::ranges::sort(packets, {}, &Placed::start);
    const double first_s = std::ranges::min(packets, {}, &Placed::time_s).time_s;
    const double last_s = std::ranges::max(packets, {}, &Placed::time_s).time_s;

    SendTimes times;
    times.is_matroska = std::string_view(format->iformat->name).find("matroska") != std::string_view::npos;
    times.duration_s = std::min(last_s - first_s, latest_time_s) + frame_duration_s(*format.get());
    times.longest_track_s = std::min(longest_track_s(packets), latest_time_s);
    // From the back: no byte is due later than one behind it.
    double due_s = latest_time_s;
    std::int64_t end = std::int64_t(std::filesystem::file_size(file));
    for (auto packet = packets.rbegin(); packet != packets.rend(); ++packet) {
        const double before = due_s;
        due_s = std::min(due_s, packet->time_s - first_s);
        if (times.parts.empty() || due_s < before)
            times.parts.push_back({end, due_s});
        end = packet->start;
    }
    std::ranges::reverse(times.parts);
    if (times.is_matroska)
        times.moments = moments_of(packets, first_s);
    else
        times.packets = due_as_decoded(std::move(packets));
    return times;
}

}  // namespace equistream
