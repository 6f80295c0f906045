/// What a server reads: what viewers send it, and the recordings that it sends them.
#include "target.h"

#include <equistream/error.h>
#include <equistream/viewer_message.h>
#include <programs/serve/programmes.h>
#include <tests/unit/plugin/stream/synthetic.h>

#include <array>
#include <cmath>

namespace equistream::fuzz {

namespace {

constexpr const char* file_name = "served.mkv";

std::filesystem::path tiled_file(const std::string& name) {
    synthetic::MadeTiles made;
    made.grid = {2, 1};
    made.pictures = 3;
    made.gop = 2;
    const std::filesystem::path file = scratch_file(name, {});
    synthetic::write(file, made);
    return file;
}

/// Takes what is due, at most `blocks` blocks of it; false: that was all.
bool take_due(serve::Feed& feed, double elapsed_s, int blocks) {
    std::array<char, 4096> block{};
    for (int i = 0; i < blocks; ++i) {
        const serve::Portion portion = feed.next(block, elapsed_s);
        require(portion.bytes <= block.size(), "no more is sent than there is room for");
        require(!portion.again_s || std::isfinite(*portion.again_s), "a time is one");
        if (portion.ended || !portion.problem.empty())
            return false;
        if (portion.bytes == 0)
            break;
    }
    return true;
}

/// What a viewer said can be said again.
void read_again(Bytes piece) {
    const std::optional<ViewerPose> pose = ViewerMessageReader().take(piece);
    if (!pose)
        return;
    const std::vector<std::uint8_t> message = encode_viewer_pose(*pose);
    const std::optional<ViewerPose> again = ViewerMessageReader().take(message);
    require(again && encode_viewer_pose(*again) == message, "what was accepted can be written and read again");
}

/// Pieces of what a viewer sends, each behind its length.
void hear(Bytes bytes) {
    static const std::unique_ptr<serve::Programme> programme =
        serve::open_recording(tiled_file("heard.mkv").string(), false);
    const std::unique_ptr<serve::Feed> feed = programme->open_feed();
    serve::LiveStream live([] {});
    const std::unique_ptr<serve::Feed> live_feed = live.open_feed();
    live.set_header("header");
    const std::unique_ptr<serve::Feed> later_feed = live.open_feed();
    Choices choices(bytes);
    for (double elapsed_s = 0; !choices.are_over(); elapsed_s += 0.02) {
        const Bytes piece = choices.take_bytes(choices.take<std::uint8_t>());
        const std::span said(reinterpret_cast<const char*>(piece.data()), piece.size());
        live.publish(std::string(piece.size(), 'x'), piece.size() % 2 == 0);
        for (serve::Feed* each : {feed.get(), live_feed.get(), later_feed.get()}) {
            each->hear(said);
            take_due(*each, elapsed_s, 4);
        }
        take_due(*live_feed, elapsed_s + 2, 4);
        if (const auto pose = live.steering())
            require(std::abs(glm::length(pose->orientation) - 1) < 1e-3 && std::isfinite(glm::length(pose->position_m)),
                    "who steers has a pose");
        if (const auto gaze = live.gaze(0.1))
            require(std::abs(glm::length(*gaze) - 1) < 1e-3, "a gaze is a direction");
        read_again(piece);
    }
    live.end();
    take_due(*live_feed, 1e3, 1000);
}

Seeds messages() {
    std::vector<std::uint8_t> bytes;
    for (int i = 0; i < 4; ++i) {
        ViewerPose pose{i / 30.0, {{0.1 * i, 1.6, 0}, glm::angleAxis(0.5 * i, glm::dvec3(0, 1, 0))}};
        if (i > 1)
            pose.view = ViewExtent{1, 0.7};
        const std::vector<std::uint8_t> message = encode_viewer_pose(pose);
        bytes.push_back(std::uint8_t(message.size()));
        bytes.insert(bytes.end(), message.begin(), message.end());
    }
    return {bytes};
}

void damage_messages(std::vector<std::uint8_t>& bytes, std::mt19937& random) {
    constexpr std::size_t mark_bytes = 4;
    static const std::vector<std::uint8_t> message = encode_viewer_pose({});
    damage_behind(Bytes(message).first(mark_bytes), message.size(), bytes, random);
}

void play(const std::filesystem::path& file, bool loop) {
    const std::unique_ptr<serve::Programme> programme = serve::open_recording(file.string(), loop);
    const std::unique_ptr<serve::Feed> feed = programme->open_feed();
    const double until_s = loop ? 2 : 1e3;
    for (double elapsed_s = 0; elapsed_s < until_s && take_due(*feed, elapsed_s, 1000);
         elapsed_s = 2 * elapsed_s + 0.1) {
    }
}

void serve_file(Bytes bytes) {
    const std::filesystem::path file = scratch_file(file_name, bytes);
    play(file, false);
    try {
        play(file, true);
    } catch (const InputError&) {
        return;  // tiles, and what is no Matroska, are played once
    }
}

Seeds recordings() {
    synthetic::Made made = synthetic::small_stream(Codec::h264, true);
    made.pictures = made.settings.pictures = 3;
    made.settings.gop = 2;
    Seeds seeds{bytes_of_file(tiled_file("seed.mkv"))};
    for (const char* name : {"seed.ts", "seed.mp4", "seed.mkv"}) {
        const std::filesystem::path file = scratch_file(name, {});
        synthetic::write(file, made);
        seeds.push_back(bytes_of_file(file));
    }
    return seeds;
}

}  // namespace

const Target viewer_messages_target{"viewer_messages", hear, messages, 150, damage_messages};
const Target served_file_target{"served_file", serve_file, recordings, 40, damage_frame_data};

}  // namespace equistream::fuzz
