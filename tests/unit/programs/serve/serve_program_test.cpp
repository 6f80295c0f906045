/// How the program starts and ends, what it says, and what our other programs make of its address.
#include "serve_fixture.h"

#include <nlohmann/json.hpp>

#include <sys/stat.h>

namespace equistream::test {
namespace {

namespace fs = std::filesystem;

TEST_F(Serving, InfoAndPlayTakeTheAddressForTheFile) {
    for (const char* name : {"a.mkv", "a.mp4"}) {
        record(name);
        Server server(arguments(name), place());
        nlohmann::json of_file = nlohmann::json::parse(run("info --frames --json '" + path(name) + "'").output);
        nlohmann::json of_url = nlohmann::json::parse(run("info --frames --json " + server.url()).output);
        EXPECT_EQ(of_url.at("source"), server.url());
        EXPECT_TRUE(of_url.at("whole"));
        of_file.erase("source");
        of_url.erase("source");
        EXPECT_EQ(of_url, of_file);

        const std::string play = " --method sphere --fill none --size 64x64 --progress none --out ";
        const Ran from_file = run("play '" + path(name) + "'" + play + "'" + path("file-eyes") + "'");
        const Ran from_url = run("play " + server.url() + play + "'" + path("url-eyes") + "'");
        ASSERT_EQ(from_file.status, 0) << from_file.errors;
        ASSERT_EQ(from_url.status, 0) << from_url.errors;
        for (int index = 5; index < 17; ++index) {
            const std::string picture = formatted("/left/frame.%04d.png", index);
            const std::string expected = text_of(path("file-eyes" + picture));
            EXPECT_GT(expected.size(), 100u) << picture;
            EXPECT_TRUE(text_of(path("url-eyes" + picture)) == expected) << name << picture;
        }
        fs::remove_all(path("file-eyes"));
        fs::remove_all(path("url-eyes"));
    }
}

TEST_F(Serving, ToOurProgramsALoopEndsWhereItBeginsAgain) {
    record("a.mkv");
    Server server(arguments("a.mkv", {"--loop"}), place());
    const nlohmann::json json = nlohmann::json::parse(run("info --frames --json " + server.url()).output);
    EXPECT_TRUE(json.at("whole")) << json.at("truncation");
    EXPECT_EQ(json.at("tracks").size(), 2u);
    for (const nlohmann::json& track : json.at("tracks")) {
        EXPECT_EQ(track.at("pictures"), 12);
        EXPECT_EQ(track.at("frames").front().at("index"), 5);
        EXPECT_EQ(track.at("frames").back().at("index"), 16);
    }
}

TEST_F(Serving, SignalsEndItInOrder) {
    record("a.mkv");
    for (const int signal_number : {SIGTERM, SIGINT}) {
        Server server(arguments("a.mkv", {"--loop"}), place());
        Viewer viewer(server.port());
        EXPECT_EQ(viewer.read(10).size(), 10u);
        EXPECT_EQ(server.end_by(signal_number), 0) << signal_number;
        viewer.read();
        EXPECT_NE(server.output().find("\nviewers served 1, refused 0, dropped 0; "), std::string::npos)
            << server.output();
    }
}

TEST_F(Serving, ReportsAsJson) {
    const std::string stream = record("a.mkv");
    Server server(arguments("a.mkv", {"--json", "--progress", "json"}), place());
    ASSERT_TRUE(comes_true([&] { return server.output().find('\n') != std::string::npos; })) << server.log();
    const std::string url = nlohmann::json::parse(server.output()).at("listening");
    Viewer viewer(static_cast<std::uint16_t>(std::stoi(url.substr(url.rfind(':') + 1))));
    EXPECT_TRUE(viewer.read() == stream);
    viewer.leave();
    EXPECT_TRUE(comes_true([&] { return server.lines_with("has all") == 1; })) << server.log();
    EXPECT_EQ(server.end_by(SIGTERM), 0);
    auto report = nlohmann::json::parse(server.output().substr(server.output().find('\n') + 1));
    EXPECT_NE(report.at("command").get<std::string>().find("--progress json"), std::string::npos);
    for (const char* of_its_making : {"command", "version", "machine"})
        EXPECT_EQ(report.erase(of_its_making), 1u) << of_its_making;
    EXPECT_EQ(report, (nlohmann::json{{"viewers", 1}, {"refused", 0}, {"dropped", 0}, {"bytes_sent", stream.size()}}));
    std::istringstream lines(server.log());
    for (const char* event : {"came", "has all"}) {
        std::string line;
        ASSERT_TRUE(std::getline(lines, line));
        EXPECT_EQ(nlohmann::json::parse(line).at("event"), event);
    }
}

TEST_F(Serving, AFolderIsEncodedFirst) {
    render("r/centre", 64, 64, 0, 3);
    fs::create_directories(folder / "tmp");
    setenv("TMPDIR", path("tmp").c_str(), 1);
    Server server(arguments("r", {"--", "--crf", "30", "--codec", "h265", "--preset", "ultrafast"}), place());
    unsetenv("TMPDIR");
    const auto json = nlohmann::json::parse(run("info --json " + server.url()).output);
    EXPECT_TRUE(json.at("whole"));
    EXPECT_EQ(json.at("tracks").at(0).at("pictures"), 4);
    EXPECT_EQ(json.at("tracks").at(0).at("codec"), "hevc");
    EXPECT_FALSE(fs::is_empty(folder / "tmp"));
    EXPECT_EQ(server.end_by(SIGTERM), 0);
    EXPECT_TRUE(fs::is_empty(folder / "tmp"));
}

TEST_F(Serving, ASignalEndsTheEncodingToo) {
    render("r/centre", 64, 64, 0, 2);
    ASSERT_EQ(mkfifo(path("r/centre/frame.0003.exr").c_str(), 0600), 0) << "a frame that never comes";
    fs::create_directories(folder / "tmp");
    setenv("TMPDIR", path("tmp").c_str(), 1);
    Server server(arguments("r"), place());
    unsetenv("TMPDIR");
    ASSERT_TRUE(comes_true([&] { return !fs::is_empty(folder / "tmp"); }));
    EXPECT_EQ(server.end_by(SIGTERM), 0) << server.log();
    EXPECT_TRUE(fs::is_empty(folder / "tmp"));
    EXPECT_EQ(server.output(), "viewers served 0, refused 0, dropped 0; 0 bytes sent\n");
}

TEST_F(Serving, BadUsageIsOneLine) {
    record("a.mkv");
    record("a.mp4");
    fs::create_directories(folder / "empty");
    std::ofstream(folder / "notes.txt") << "nothing to see\n";
    const auto serve = [&](const std::string& name, const std::string& more) {
        return run("serve '" + path(name) + "' " + more);
    };
    expect_failure(serve("absent.mkv", "--listen tcp://:0"), 2, "absent.mkv: no such file or folder");
    expect_failure(serve("notes.txt", "--listen tcp://:0"), 2, "expected a video");
    for (const char* url : {"tcp://127.0.0.1", "tcp://127.0.0.1:0", "tcp://127.0.0.1:99999", "tcp://127.0.0.1:a"})
        for (const std::string& program : {std::string("info "), "play --out '" + path("eyes") + "' "})
            expect_failure(run(program + url), 2, "expected tcp://HOST:PORT with a port of 1 to 65535");
    expect_failure(serve("empty", "--listen tcp://:0"), 2, "equistream encode: ");
    expect_failure(serve("a.mkv", ""), 2, "--listen is required");
    for (const char* url : {"udp://:0", "tcp://127.0.0.1", "tcp://:65536", "tcp://:", "tcp://:-1", "tcp://::1:0", ":0"})
        expect_failure(serve("a.mkv", "--listen " + std::string(url)), 2, "expected tcp://HOST:PORT");
    expect_failure(serve("a.mkv", "--listen tcp://no.such.host.invalid:0"), 2, "expected a host that is known");
    expect_failure(serve("a.mkv", "--listen tcp://:0 --patience nan"), 2, "--patience: expected 0.1 to 86400 s");
    expect_failure(serve("a.mkv", "--listen tcp://:0 --viewers 0"), 2, "--viewers: expected at least 1");
    expect_failure(serve("a.mp4", "--listen tcp://:0 --loop"), 2, "expected Matroska for --loop");
    expect_failure(serve("a.mkv", "--listen tcp://:0 -- --crf 20"), 2, "expected a folder");
    Server first(arguments("a.mkv"), place());
    expect_failure(serve("a.mkv", "--listen " + first.url()), 2, "expected an address that is free");
}

}  // namespace
}  // namespace equistream::test
