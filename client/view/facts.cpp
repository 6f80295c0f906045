#include "facts.h"

#include <equistream/conventions.h>
#include <equistream/rec709.h>
#include <equistream/text.h>

#include <unistd.h>

#include <cmath>
#include <fstream>

namespace equistream {

namespace {

constexpr double mebibyte = 1 << 20;

std::string in_mib(std::size_t bytes) {
    return formatted("%.0f MiB", double(bytes) / mebibyte);
}

std::string degrees(double rad) {
    return formatted("%.2f", rad * 180 / pi + 0.0);
}

std::string picture_size(const ReceivedPicture& picture) {
    return size_text(picture.width(), picture.height());
}

}  // namespace

std::vector<Fact> source_facts(const std::string& name, const WatchedSource& source, const ReceivedFrame& frame) {
    const FrameInfo& info = frame.main.info;
    const FeedSummary& summary = source.loader.summary();
    constexpr PanelSection section = PanelSection::source;
    std::vector<Fact> facts = {{section, "name", name},
                               {section, "kind", summary.kind + (source.loader.is_live() ? ", live" : "")},
                               {section, "size", picture_size(frame.main)}};
    if (info.window_columns > 0)
        facts.push_back({section, "window of", formatted("%d columns", info.window_columns)});
    if (frame.base)
        facts.push_back({section, "sphere", picture_size(*frame.base)});
    if (!summary.codec.empty())
        facts.push_back({section, "codec", summary.codec});
    if (!frame.main.decoder.empty())
        facts.push_back({section, "decoder", std::string(frame.main.decoder)});
    facts.push_back({section, "frame", std::to_string(info.index)});
    facts.push_back({section, "time", formatted("%.3f s", info.time_s)});
    if (const double seconds = source.seconds(); seconds > 0)
        facts.push_back({section, "length", formatted("%.2f s", seconds)});
    facts.push_back({section, "frames/s", in_words(info.frames_per_second)});
    if (!info.scene.empty())
        facts.push_back({section, "scene", info.scene});
    if (!info.host.empty())
        facts.push_back({section, "rendered by", info.host});
    if (info.samples_per_pixel > 0)
        facts.push_back({section, "samples", std::to_string(info.samples_per_pixel) + " a pixel"});
    return facts;
}

std::vector<Fact> method_facts(const MethodState& state, const ReceivedFrame& frame) {
    const std::string depth = !frame.posed        ? "none (ordinary video)"
                              : !state.has_depth  ? "none in the stream"
                              : state.by_geometry ? "from the scene's geometry"
                                                  : "of the stream";
    return {{PanelSection::method, "in use", state.engine},
            {PanelSection::method, "depth", depth},
            {PanelSection::method, "moving things",
             state.is_extrapolated            ? "extrapolated to now"
             : frame.main.info.moving.empty() ? "no data"
                                              : "as in the frame"},
            {PanelSection::method, "head box", formatted("%.0f cm", 100 * head_box_radius(frame.main.info))}};
}

std::vector<Fact> network_facts(const Playback& playback, const LoaderFigures& figures, const NetworkState& state) {
    constexpr PanelSection section = PanelSection::network;
    const PlaybackCounts counts = playback.counts();
    std::vector<Fact> facts = {
        {section, "received", formatted("%.2f Mbit/s", 1e-6 * state.bits_per_second)},
        {section, "so far",
         formatted("%lld frames, %.2f MB", static_cast<long long>(figures.frames), 1e-6 * double(figures.bytes))},
        {section, "lost", std::to_string(counts.lost)},
        {section, "skipped", std::to_string(counts.skipped)}};
    if (!playback.is_live())
        return facts;
    const std::string connection =
        !state.lateness.empty() ? state.lateness : clock_state_names[std::size_t(playback.state())];
    facts.push_back({section, "late", std::to_string(counts.late)});
    facts.push_back({section, "play-out delay", formatted("%.0f ms", 1e3 * playback.playout_delay_s())});
    facts.push_back({section, "jitter", formatted("%.1f ms", 1e3 * playback.jitter_s())});
    facts.push_back({section, "connection", connection});
    facts.push_back({section, "reconnected", std::to_string(figures.reconnections) + " times"});
    facts.push_back(
        {section, "steering", state.is_followed ? "the server follows this head" : "the server's own path"});
    return facts;
}

std::vector<Fact> speed_facts(const SpeedState& state) {
    constexpr PanelSection section = PanelSection::speed;
    return {{section, "refreshes", formatted("%.1f a second", state.refreshes_per_second)},
            {section, "frames", formatted("%.1f a second", state.frames_per_second)},
            {section, "latency", formatted("%.1f ms", 1e3 * state.latency_s)},
            {section, "decoding", formatted("%.1f ms a frame", state.decode_ms)},
            {section, "memory", in_mib(resident_bytes())},
            {section, "on the GPU", in_mib(state.gpu_bytes)},
            {section, "decoders' buffers", in_mib(state.mapped_bytes)}};
}

std::vector<Fact> mouse_facts(const gl::PixelValues& values, const PerspectiveCamera& camera, const Pose& eye,
                              const ReceivedFrame& frame) {
    constexpr PanelSection section = PanelSection::mouse;
    const FrameInfo& info = frame.main.info;
    const double u = values.pixel.x + 0.5, v = values.pixel.y + 0.5;
    const glm::dvec3 ray = camera.direction(u, v);
    const glm::dvec3 ahead = glm::conjugate(info.camera_pose.orientation) * (eye.orientation * ray);
    const Vector3<double> direction{ahead.x, ahead.y, ahead.z};
    const glm::dvec2 source = pixel_of(info.camera, ahead);
    const auto& rgba = values.rgba;
    std::vector<Fact> facts = {
        {section, "pixel of the eye", formatted("%d, %d", values.pixel.x, values.pixel.y)},
        {section, "looks to", degrees(longitude_of(direction)) + ", " + degrees(latitude_of(direction)) + " deg"},
        {section, "in the frame", formatted("%.1f, %.1f", source.x, source.y)},
        {section, "colour, 8 bit", formatted("%d %d %d", rgba[0], rgba[1], rgba[2])},
        {section, "colour, linear",
         formatted("%.4f %.4f %.4f", double(srgb_to_linear(float(rgba[0]) / 255)),
                   double(srgb_to_linear(float(rgba[1]) / 255)), double(srgb_to_linear(float(rgba[2]) / 255)))},
        {section, "coloured by",
         std::string(gl::origin_words[std::min<std::size_t>(values.origin, pixel_origin_count - 1)])}};
    if (values.inverse_m) {
        const double inverse = double(*values.inverse_m);
        facts.push_back({section, "depth",
                         inverse > 0           ? formatted("%.3f m", 1 / (inverse * -ray.z))
                         : std::isnan(inverse) ? "not known"
                                               : "no surface"});
    }
    if (values.reliability)
        facts.push_back({section, "confidence", formatted("%.0f %%", 100 * double(*values.reliability))});
    return facts;
}

std::size_t resident_bytes() {
    std::ifstream file("/proc/self/statm");
    std::size_t all = 0, resident = 0;
    file >> all >> resident;
    return file ? resident * std::size_t(sysconf(_SC_PAGESIZE)) : 0;
}

}  // namespace equistream
