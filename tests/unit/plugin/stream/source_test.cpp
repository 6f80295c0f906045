/// Addresses that libav opens: a server that does not answer, or says nothing, is given up in time.
#include <plugin/stream/source.h>
#include <tests/unit/silent_server.h>

#include "synthetic.h"

#include <equistream/error.h>

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
    std::ifstream in(folder / "a.mkv", std::ios::binary);
    const std::string stream{std::istreambuf_iterator<char>(in), {}};
    SilentServer server;
    std::thread sending([&] { server.send(stream.substr(0, stream.size() - 50)); });
    const StreamReadOptions options;
    Source source(server.address(), options, impatient);
    sending.join();
    const av::Packet packet = av::make_packet();
    while (source.begin_waiting(), av_read_frame(source.get(), packet.get()) >= 0)
        av_packet_unref(packet.get());
    EXPECT_EQ(source.problem(), "the server sent nothing for 0.2 s");
}

TEST(Sources, WhatAReadingFunctionThrowsIsTheReason) {
    const StreamReadOptions options{
        .read = [](std::span<std::uint8_t>) -> std::size_t { throw WorkError("the line is dead"); }};
    EXPECT_EQ(refusal("tcp://nobody:1", options), "tcp://nobody:1: the line is dead");
}

}  // namespace
}  // namespace equistream::test
