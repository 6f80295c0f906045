/// What strangers who can reach the server do to it and to its viewers (docs/security.md).
#include "serve_fixture.h"

#include <nlohmann/json.hpp>

#include <memory>
#include <random>
#include <string>
#include <vector>

namespace equistream::test {
namespace {

TEST_F(Serving, OneAddressHasNoMoreThanItsShare) {
    record_large("a.mkv");
    Server server(arguments("a.mkv", {"--per-address", "2"}), place());
    const std::uint16_t port = server.port();
    Viewer first(port), second(port);
    EXPECT_EQ(first.read(10).size(), 10u);
    EXPECT_EQ(second.read(10).size(), 10u);
    Viewer third(port);
    EXPECT_TRUE(third.read().empty());
    EXPECT_EQ(server.lines_with("refused: 2 viewers from there are connected already (--per-address)"), 1)
        << server.log();
    first.leave();
    EXPECT_TRUE(comes_true([&] { return server.lines_with(" left") == 1; })) << server.log();
    Viewer fourth(port);
    EXPECT_EQ(fourth.read(10).size(), 10u);
}

TEST_F(Serving, FromThisMachineAnyNumberMayCome) {
    record_large("a.mkv");
    Server server(arguments("a.mkv"), place());
    const std::uint16_t port = server.port();
    std::vector<std::unique_ptr<Viewer>> viewers;
    for (int i = 0; i < 8; ++i) {
        viewers.push_back(std::make_unique<Viewer>(port));
        EXPECT_EQ(viewers.back()->read(10).size(), 10u) << i;
    }
}

/// 500 at once, and 1,000 that come and go, some of them broken off.
TEST_F(Serving, AFloodOfConnectionsSpoilsNeitherAViewersStreamNorTheLog) {
    const std::string stream = record_large("a.mkv");
    Server server(arguments("a.mkv", {"--viewers", "3"}), place());
    const std::uint16_t port = server.port();
    const auto start = Clock::now();
    Viewer viewer(port);
    EXPECT_EQ(viewer.read(10).size(), 10u);
    std::size_t read = 10;
    const auto read_on = [&] {
        read += 10000;
        EXPECT_EQ(viewer.read(read).size(), read);
    };
    std::vector<std::unique_ptr<Viewer>> many;
    for (int i = 0; i < 500; ++i) {
        many.push_back(std::make_unique<Viewer>(port));
        read_on();
    }
    for (int i = 0; i < 1000; ++i) {
        Viewer passing(port);
        if (i % 3 == 0)
            passing.break_off();
        read_on();
    }
    EXPECT_LT(read, stream.size());
    EXPECT_TRUE(viewer.read() == stream);
    viewer.leave();
    const double max_lines = 20 + 2 * seconds_since(start) + 2;
    EXPECT_EQ(server.end_by(SIGTERM), 0) << server.log();
    EXPECT_LE(server.lines_with("viewer"), int(max_lines)) << server.log();
    EXPECT_GE(server.lines_with("refused: 3 viewers are connected already (--viewers)"), 1) << server.log();
    EXPECT_GE(server.lines_with(" log lines about viewers were skipped"), 1) << server.log();
}

/// A client that reconnects as soon as it is refused gets one connection a second.
TEST_F(Serving, WhoIsRefusedIsClosedASecondLater) {
    record_large("a.mkv");
    Server server(arguments("a.mkv", {"--viewers", "1", "--patience", "100"}), place());
    const std::uint16_t port = server.port();
    Viewer viewer(port);
    EXPECT_EQ(viewer.read(10).size(), 10u);
    const auto start = Clock::now();
    for (int i = 1; i <= 3; ++i) {
        EXPECT_TRUE(Viewer(port).read().empty());
        EXPECT_GE(seconds_since(start), 0.99 * i);
    }
}

TEST_F(Serving, WhoDoesNotKnowTheSecretIsClosedASecondLater) {
    record("a.mkv");
    Server server({path("a.mkv"), "--listen", "tls://:0"}, place());
    const std::uint16_t port = server.port();
    const auto start = Clock::now();
    Viewer stranger(port);
    say(stranger, std::string(100, 'x'));
    stranger.read();
    EXPECT_GE(seconds_since(start), 0.99);
    EXPECT_LT(seconds_since(start), 9) << "long before those who say nothing";
}

TEST_F(Serving, SaysWhoCanComeToIt) {
    record("a.mkv");
    for (const auto& [listen, said] : {std::pair("tcp://0.0.0.0:0", "no secret, no encryption"),
                                       std::pair("tls://0.0.0.0:0", "anyone with the secret who can reach tls://"),
                                       std::pair("srt://0.0.0.0:0", "anyone with the secret who can reach srt://")}) {
        Server server({path("a.mkv"), "--listen", listen, "--open"}, place());
        ASSERT_TRUE(comes_true([&] { return server.lines_with(said) == 1; })) << listen;
    }
    for (const auto& [listen, lines] : {std::pair("tcp://0.0.0.0:0", 1), std::pair("tcp://:0", 0)}) {
        Server server({path("a.mkv"), "--listen", listen, "--open", "--progress", "none"}, place());
        ASSERT_TRUE(comes_true([&] { return server.output().find('\n') != std::string::npos; })) << listen;
        EXPECT_EQ(server.lines_with("no secret, no encryption"), lines);
        EXPECT_EQ(server.lines_with(""), lines);
    }
    Server server(arguments("a.mkv"), place());
    server.url();
    EXPECT_EQ(server.log(), "");
}

class Encrypted : public Serving, public testing::WithParamInterface<std::string> {};

INSTANTIATE_TEST_SUITE_P(Over, Encrypted, testing::Values("tls", "srt"),
                         [](const auto& scheme) { return scheme.param; });

TEST_P(Encrypted, WhoeverKnowsTheSecretGetsTheStreamAndNobodyElse) {
    record("a.mkv");
    Server server({path("a.mkv"), "--listen", GetParam() + "://:0"}, place());
    const std::string url = server.url();
    const auto at = url.find('@');
    ASSERT_NE(at, std::string::npos) << url;
    const std::string scheme = GetParam() + "://", secret = url.substr(scheme.size(), at - scheme.size());
    const Ran of_url = run("info --json " + url);
    ASSERT_EQ(of_url.status, 0) << of_url.errors;
    const nlohmann::json json = nlohmann::json::parse(of_url.output);
    EXPECT_TRUE(json.at("whole"));
    EXPECT_EQ(of_url.output.find(secret), std::string::npos) << of_url.output;

    const std::string bare = scheme + url.substr(at + 1);
    expect_failure(run("info " + bare), 2, "expected the server's secret");
    expect_failure(run("info " + scheme + "not-the-right-secret@" + url.substr(at + 1)), 2,
                   bare + ": expected a server with this secret");
    if (GetParam() == "tls") {
        Viewer plain(server.port());
        EXPECT_EQ(send(plain.handle(), "GET / HTTP/1.1\r\n\r\n", 18, MSG_NOSIGNAL), 18);
        EXPECT_LT(plain.read().size(), 64u) << "an alert at most";
    }
    const int refused = GetParam() == "tls" ? 2 : 1;
    EXPECT_TRUE(
        comes_true([&] { return server.lines_with("refused: it did not prove that it has the secret") == refused; }));
    EXPECT_EQ(server.end_by(SIGTERM), 0);
    EXPECT_EQ(server.log().find(secret), std::string::npos);
}

/// What is no SRT, and no TLS within it, does not keep viewers away.
TEST_F(Serving, OverSrtStrangersPacketsAreNothing) {
    record("a.mkv");
    Server server({path("a.mkv"), "--listen", "srt://:0"}, place());
    const std::string url = server.url();
    const int socket_handle = socket(AF_INET, SOCK_DGRAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(server.port());
    std::mt19937 random(1);
    for (int i = 0; i < 500; ++i) {
        std::string packet(random() % 1400, ' ');
        for (char& c : packet)
            c = char(random());
        sendto(socket_handle, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&address),
               sizeof address);
    }
    close(socket_handle);
    EXPECT_EQ(run("info --json " + url).status, 0) << server.log();
    EXPECT_EQ(server.end_by(SIGTERM), 0);
}

TEST_F(Serving, NoMoreThanSoManyAreWaitedForToShowThatTheyKnowTheSecret) {
    record("a.mkv");
    Server server({path("a.mkv"), "--listen", "tls://:0"}, place());
    const std::string url = server.url();
    std::vector<std::unique_ptr<Viewer>> silent;
    for (int i = 0; i < 65; ++i)
        silent.push_back(std::make_unique<Viewer>(server.port()));
    EXPECT_TRUE(comes_true([&] { return server.lines_with("refused: 64 viewers are connecting already") == 1; }));
    silent.clear();
    EXPECT_TRUE(comes_true([&] { return run("info --json " + url).status == 0; })) << server.log();
}

TEST_F(Serving, WhoeverDoesNotShowThatItKnowsTheSecretHasTenSeconds) {
    record("a.mkv");
    Server server({path("a.mkv"), "--listen", "tls://:0"}, place());
    const auto start = Clock::now();
    Viewer silent(server.port());
    EXPECT_EQ(silent.read(), "");
    EXPECT_GT(seconds_since(start), 9);
    EXPECT_LT(seconds_since(start), give_up_s);
    EXPECT_TRUE(comes_true([&] { return server.lines_with("refused: it did not prove that it has the secret") == 1; }))
        << server.log();
}

TEST_F(Serving, ASecretIsKeptInAFile) {
    record("a.mkv");
    const std::string file = path("secret");
    Server server({path("a.mkv"), "--listen", "tls://:0", "--secret-file", file}, place());
    const std::string url = server.url();
    std::string secret = text_of(file);
    ASSERT_EQ(secret.size(), 27u);
    secret.pop_back();
    EXPECT_EQ(url.find(secret), std::string::npos);
    EXPECT_EQ(run_line("EQUISTREAM_SECRET=" + secret + " " EQUISTREAM_BIN "/equistream-info " + url).status, 0);
}

}  // namespace
}  // namespace equistream::test
