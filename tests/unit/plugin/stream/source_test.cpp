/// What libav reads: a server that does not answer, or says nothing, is given up in time, and a silent pipe when asked.
#include <plugin/stream/source.h>
#include <tests/unit/pipe_writer.h>
#include <tests/unit/silent_server.h>

#include "synthetic.h"

#include <equistream/error.h>

#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <iterator>
#include <thread>

namespace equistream::test {
namespace {

constexpr Patience impatient{.connect_s = 0.3, .first_bytes_s = 0.4, .silence_s = 0.2};

std::string refusal(const std::string& address, const StreamReadOptions& options = {}) {
    const auto start = Clock::now();
    try {
        Source(address, options, impatient);
    } catch (const WorkError& error) {
        EXPECT_LT(seconds_since(start), 5);
        return error.what();
    }
    ADD_FAILURE() << "no WorkError was thrown";
    return {};
}

std::string bytes_of(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

TEST(Sources, AServerThatDoesNotAnswerIsGivenUp) {
    SilentServer server(0);
    server.fill_up(0);
    EXPECT_EQ(refusal(server.address()), server.address() + ": the server did not answer for 0.3 s");
}

TEST(Sources, AServerThatSaysNothingIsGivenUp) {
    SilentServer server;
    EXPECT_EQ(refusal(server.address()), server.address() + ": the server sent nothing for 0.4 s");
}

TEST(Sources, AServerThatFallsSilentIsGivenUp) {
    const synthetic::Folder folder;
    synthetic::write(folder / "a.mkv", synthetic::small_stream(Codec::h264, false));
    const std::string stream = bytes_of(folder / "a.mkv");
    SilentServer server;
    std::jthread sending([&] { server.send(stream.substr(0, stream.size() - 50)); });
    const StreamReadOptions options;
    Source source(server.address(), options, impatient);
    sending.join();
    const av::Packet packet = av::make_packet();
    while (source.begin_waiting(), av_read_frame(source.get(), packet.get()) >= 0)
        av_packet_unref(packet.get());
    EXPECT_EQ(source.problem(), "the server sent nothing for 0.2 s");
}

TEST(Sources, ASilentPipeIsLeftWhenThatIsAsked) {
    const synthetic::Folder folder;
    const std::string named = (folder / "a.mkv").string();
    ASSERT_EQ(mkfifo(named.c_str(), 0600), 0);
    int ends[2];
    ASSERT_EQ(pipe(ends), 0);
    for (const std::string& name : {named, "pipe:" + std::to_string(ends[0])}) {
        const auto start = Clock::now();
        const StreamReadOptions options{.interrupted = [&] { return seconds_since(start) > 0.2; }};
        EXPECT_THROW(Source(name, options), InputError);
        EXPECT_LT(seconds_since(start), 5) << name;
    }
    close(ends[0]);
    close(ends[1]);
}

TEST(Sources, APipeThatIsOpenAlreadyEndsWhenItsWriterHasGone) {
    int ends[2];
    ASSERT_EQ(pipe(ends), 0);
    close(ends[1]);
    const std::string number = std::to_string(ends[0]);
    for (const std::string& name : {"pipe:" + number, "/dev/fd/" + number, std::string("pipe:-1")}) {
        const auto start = Clock::now();
        const StreamReadOptions options{.interrupted = [&] { return seconds_since(start) > 5; }};
        EXPECT_THROW(Source(name, options), InputError);
        EXPECT_LT(seconds_since(start), 5) << name;
    }
    close(ends[0]);
}

TEST(Sources, ANamedPipeGivesWhatIsWrittenIntoItInParts) {
    const synthetic::Folder folder;
    const synthetic::Made made = synthetic::small_stream(Codec::h264, false);
    synthetic::write(folder / "a.mkv", made);
    const std::string stream = bytes_of(folder / "a.mkv"), named = (folder / "pipe.mkv").string();
    ASSERT_EQ(mkfifo(named.c_str(), 0600), 0);
    const PipeWriter writing(named, stream, 5000);
    StreamReader reader(named);
    EXPECT_EQ(synthetic::read_all(reader).size(), std::size_t(made.pictures));
    EXPECT_EQ(reader.truncation(), "");
}

TEST(Sources, APipeIsReadOnce) {
    const synthetic::Folder folder;
    const std::string file = (folder / "a.mkv").string(), named = (folder / "pipe.mkv").string();
    synthetic::write(file, synthetic::small_stream(Codec::h264, false));
    ASSERT_EQ(mkfifo(named.c_str(), 0600), 0);
    EXPECT_TRUE(is_pipe(named));
    EXPECT_TRUE(is_pipe("pipe:0"));
    EXPECT_FALSE(is_pipe(file));
    EXPECT_FALSE(is_pipe("tcp://127.0.0.1:9000"));
    const PipeWriter writing(named, bytes_of(file));
    StreamReader reader(named);
    EXPECT_TRUE(reader.next());
    EXPECT_FALSE(reader.seconds()) << "although its header says it";
    EXPECT_FALSE(reader.seek(0));
}

TEST(Sources, WhatAReadingFunctionThrowsIsTheReason) {
    const StreamReadOptions options{
        .read = [](std::span<std::uint8_t>) -> std::size_t { throw WorkError("the line is dead"); }};
    EXPECT_EQ(refusal("tcp://nobody:1", options), "tcp://nobody:1: the line is dead");
}

TEST(Sources, ModelsAndRawPicturesAreNoVideo) {
    const synthetic::Folder folder;
    std::string pictures;
    for (int i = 0; i < 40; ++i)
        pictures += std::string("\xff\xd8\xff\xc0\0\0\xff\xda\0\0\xff\xd9\0\0", 14);  // the markers of a JPEG
    std::ofstream(folder / "a.glb", std::ios::binary) << "glTF" << pictures;
    std::ofstream(folder / "a.mjpeg", std::ios::binary) << pictures;
    const StreamReadOptions options;
    for (const auto& [name, found] : {std::pair("a.glb", "found a model"), {"a.mjpeg", "found a picture"}})
        try {
            Source((folder / name).string(), options);
            ADD_FAILURE() << name << " was taken for a video";
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find(found), std::string::npos) << error.what();
        }
}

/// A server does so for each viewer of tiles.
TEST(Sources, OfWhatIsOnlyPassedOnLittleIsReadFirst) {
    const synthetic::Folder folder;
    synthetic::write(folder / "a.mkv", synthetic::MadeTiles{.grid = {8, 4}, .pictures = 24, .gop = 10});
    const StreamReadOptions options;
    const Source decoded((folder / "a.mkv").string(), options), copied((folder / "a.mkv").string(), options, {}, true);
    EXPECT_LT(2 * avio_tell(copied->pb), avio_tell(decoded->pb));
}

}  // namespace
}  // namespace equistream::test
