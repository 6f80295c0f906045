/// How the program starts and ends, what it says, and what our other programs make of its address.
#include "serve_fixture.h"

#include <equistream/send_times.h>

#include <nlohmann/json.hpp>

#include <random>

namespace equistream::test {
namespace {

namespace fs = std::filesystem;

/// A Matroska file whose segment's size, of eight bytes, is not known.
std::string as_sent_in_a_loop(std::string file) {
    const std::size_t at = file.find("\x18\x53\x80\x67\x01");
    EXPECT_NE(at, std::string::npos);
    return file.replace(at + 5, 7, 7, '\xff');
}

TEST_F(Serving, InfoAndPlayTakeTheAddressForTheFile) {
    for (const char* name : {"a.mkv", "a.mp4"}) {
        record(name);
        Server server(arguments(name), place());
        nlohmann::json of_file = nlohmann::json::parse(run("info --frames --json '" + path(name) + "'").output);
        nlohmann::json of_url = nlohmann::json::parse(run("info --frames --json " + server.url()).output);
        EXPECT_EQ(of_url.at("source"), server.url());
        EXPECT_TRUE(of_url.at("whole"));
        for (const char* its_own : {"source", "command"}) {
            of_file.erase(its_own);
            of_url.erase(its_own);
        }
        for (std::size_t i = 0; i < of_file.at("tracks").size(); ++i) {
            EXPECT_TRUE(of_url.at("tracks").at(i).at("vexu").is_null()) << "boxes are read in files alone";
            of_file.at("tracks").at(i).at("vexu") = nullptr;
        }
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
    render("r/centre", 512, 256, 0, 0);
    for (int index = 1; index < 1000; ++index)  // much to do, before which the signal comes
        fs::create_symlink("frame.0000.exr", folder / "r/centre" / frame_file_name(index));
    fs::create_directories(folder / "tmp");
    setenv("TMPDIR", path("tmp").c_str(), 1);
    Server server(arguments("r", {"--", "--preset", "veryslow"}), place());
    unsetenv("TMPDIR");
    ASSERT_TRUE(comes_true([&] { return !fs::is_empty(folder / "tmp"); }));
    EXPECT_EQ(server.end_by(SIGTERM), 0) << server.log();
    EXPECT_TRUE(fs::is_empty(folder / "tmp"));
    EXPECT_EQ(server.output(), "viewers served 0, refused 0, dropped 0; 0 bytes sent\n");
}

TEST_F(Serving, ASignalEndsTheReadingToo) {
    synthetic::Made made = synthetic::small_stream(Codec::h264, false);
    made.pictures = 60;  // of which libav looks at some before it reads
    made.settings.pictures = 60;
    synthetic::write(folder / "a.mkv", made);
    fs::resize_file(folder / "a.mkv", std::uintmax_t{32} << 30);  // a hole, through which a cluster is looked for
    Server server(arguments("a.mkv"), place());
    ASSERT_TRUE(comes_true([&] { return server.lines_with("reading " + path("a.mkv") + " (34.4 GB)") == 1; }))
        << server.log();
    EXPECT_EQ(server.end_by(SIGINT), 0) << server.log();
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
    expect_failure(serve("a.mkv", ""), 2, "--listen: expected tcp://HOST:PORT, or --web PORT, found neither");
    for (const char* web : {"65536", "a", "127.0.0.1:", "[::1"})
        expect_failure(serve("a.mkv", "--web " + std::string(web)), 2, "--web: expected");
    for (const char* url : {"udp://:0", "tcp://127.0.0.1", "tcp://:65536", "tcp://:", "tcp://:-1", "tcp://::1:0", ":0"})
        expect_failure(serve("a.mkv", "--listen " + std::string(url)), 2, "expected tcp://HOST:PORT");
    expect_failure(serve("a.mkv", "--listen tcp://0.0.0.0:0"), 2,
                   "expected tls:// or srt:// beyond this machine, or --open");
    Server srt({path("a.mkv"), "--listen", "srt://0.0.0.0:0"}, place());
    EXPECT_TRUE(comes_true([&] { return srt.lines_with("anyone with the secret who can reach srt://") == 1; }));
    expect_failure(serve("a.mkv", "--listen tls://short@:0"), 2, "expected a secret of 16 to 128 characters");
    expect_failure(serve("a.mkv", "--listen tcp://:0 --secret-file x"), 2,
                   "--secret-file: expected --listen tls:// or srt://");
    expect_failure(serve("a.mkv", "--listen tls://a-secret-of-enough-letters@:0 --secret-file x"), 2,
                   "--secret-file: expected an address without a secret");
    std::ofstream(folder / "scene.json") << "{}";
    expect_failure(serve("scene.json", "--listen tcp://:0 --out '" + path("none/a.mkv") + "'"), 2,
                   "expected a folder that can be written to");
    std::ofstream(folder / "own.mkv") << "somebody's";
    expect_failure(serve("scene.json", "--listen tcp://:0 --out '" + path("own.mkv") + "'"), 2,
                   "expected a new name, or an earlier stream of equistream to replace, found another file");
    expect_failure(serve("scene.json", "--listen tcp://:0 -- --spp 4"), 2,
                   "-- --spp: expected an option of render that serve does not set itself");
    expect_failure(run("info tls://a-secret-of-enough-letters@:1"), 2, "tls://:1: expected tcp://HOST:PORT");
    expect_failure(serve("a.mkv", "--listen tcp://no.such.host.invalid:0"), 2, "expected a host name that resolves");
    expect_failure(serve("a.mkv", "--listen tcp://:0 --patience nan"), 2, "--patience: expected a number, found 'nan'");
    expect_failure(serve("a.mkv", "--web https://a-secret-of-enough-letters@:0"), 2, "found 'https://***@:0'");
    expect_failure(serve("a.mkv", "--listen tcp://:0 --viewers 0"), 2, "--viewers: expected at least 1");
    expect_failure(serve("a.mp4", "--listen tcp://:0 --loop"), 2, "expected Matroska for --loop");
    expect_failure(serve("a.mkv", "--listen tcp://:0 -- --crf 20"), 2, "expected a folder");
    expect_failure(serve("a.mkv", "--listen tcp://:0 --crf 20"), 2,
                   "expected a scene (.json, .xml) to render, found none");
    expect_failure(serve("empty", "--listen tcp://:0 --depth auto"), 2,
                   "--depth: " + path("empty") + ": expected a scene (.json, .xml) to render, found a folder; " +
                       "options of encode follow --, such as -- --depth auto");
    expect_failure(serve("empty", "--listen tcp://:0 --spp 4"), 2, "to render, found a folder");
    synthetic::write(folder / "t.mkv", synthetic::MadeTiles{.pictures = 2});
    expect_failure(serve("t.mkv", "--listen tcp://:0 --loop"), 2,
                   "--loop: " + path("t.mkv") + ": expected a stream without tiles, found one with tiles");
    Server first(arguments("a.mkv"), place());
    expect_failure(serve("a.mkv", "--listen " + first.url()), 2, "expected a free address of this machine");
}

}  // namespace

// What viewers get, good ones and bad ones.

namespace {

std::int64_t due_at(const SendTimes& times, double time_s) {
    std::int64_t bytes = 0;
    for (const DueBytes& part : times.parts)
        if (part.time_s <= time_s)
            bytes = part.end;
    return bytes;
}

TEST_F(Serving, TwoViewersGetTheBytesOfTheFile) {
    for (const char* name : {"a.mkv", "a.mp4"}) {
        const std::string stream = record(name);
        Server server(arguments(name), place());
        Viewer first(server.port()), second(server.port());
        std::thread beside([&] { second.read(); });
        EXPECT_TRUE(first.read() == stream) << name << ": " << first.read().size() << " of " << stream.size();
        beside.join();
        EXPECT_TRUE(second.read() == stream) << name << ": " << second.read().size() << " of " << stream.size();
        first.leave();
        second.leave();
        EXPECT_TRUE(comes_true([&] { return server.lines_with("has all") == 2; })) << server.log();
        EXPECT_EQ(server.end_by(SIGTERM), 0);
    }
}

TEST_F(Serving, NoByteComesBeforeItIsDue) {
    const std::string stream = record("a.mkv");
    const SendTimes times = read_send_times(path("a.mkv"));
    ASSERT_GT(times.parts.back().time_s, 0.2);
    Server server(arguments("a.mkv"), place());
    Viewer viewer(server.port());
    EXPECT_TRUE(viewer.read() == stream);
    ASSERT_FALSE(viewer.arrivals().empty());
    for (const Arrival& arrival : viewer.arrivals())
        EXPECT_LE(arrival.bytes, due_at(times, arrival.elapsed_s)) << "at " << arrival.elapsed_s << " s";
    EXPECT_GE(viewer.arrivals().back().elapsed_s, times.parts.back().time_s);
}

TEST_F(Serving, ALoopBeginsAgainNoEarlierThanItEnds) {
    const std::string stream = as_sent_in_a_loop(record("a.mkv"));
    const SendTimes times = read_send_times(path("a.mkv"));
    EXPECT_NEAR(times.duration_s, 0.4, 1e-3);
    Server server(arguments("a.mkv", {"--loop"}), place());
    Viewer viewer(server.port());
    EXPECT_TRUE(viewer.read(2 * stream.size() + 1000) == stream + stream + stream.substr(0, 1000));
    for (const Arrival& arrival : viewer.arrivals()) {
        if (arrival.bytes > std::int64_t(stream.size())) {
            EXPECT_GE(arrival.elapsed_s, times.duration_s) << arrival.bytes;
        }
        if (arrival.bytes > std::int64_t(2 * stream.size())) {
            EXPECT_GE(arrival.elapsed_s, 2 * times.duration_s) << arrival.bytes;
        }
    }
    EXPECT_EQ(server.end_by(SIGTERM), 0) << "while it is sending";
    EXPECT_LT(viewer.read().size(), 100 * stream.size());
}

TEST_F(Serving, ViewersMayLeaveAndReturn) {
    const std::string stream = as_sent_in_a_loop(record("a.mkv"));
    Server server(arguments("a.mkv", {"--loop"}), place());
    for (int visit = 0; visit < 3; ++visit) {
        Viewer leaving(server.port()), breaking(server.port());
        EXPECT_EQ(leaving.read(100).size(), 100u);
        EXPECT_EQ(breaking.read(100).size(), 100u);
        leaving.leave();
        breaking.break_off();
    }
    EXPECT_TRUE(comes_true([&] { return server.lines_with(" left") == 6; })) << server.log();
    Viewer returned(server.port());
    EXPECT_TRUE(returned.read(stream.size()) == stream);
    EXPECT_EQ(server.end_by(SIGTERM), 0);
}

/// What it is sent a server that reads all it can takes by the gigabyte; systems on the way keep some megabytes.
TEST_F(Serving, GarbageIsReadSlowlyAndDropped) {
    constexpr std::int64_t max_accepted = 24 << 20;
    constexpr double sending_s = 1;
    const std::string stream = as_sent_in_a_loop(record("a.mkv"));
    Server server(arguments("a.mkv", {"--loop"}), place());
    Viewer rude(server.port());
    const std::string garbage(1 << 16, '\xa5');
    std::int64_t accepted = 0;
    for (const auto start = Clock::now(); seconds_since(start) < sending_s;) {
        const ssize_t count = send(rude.handle(), garbage.data(), garbage.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
        ASSERT_TRUE(count > 0 || errno == EAGAIN) << errno;
        accepted += std::max<ssize_t>(count, 0);
        if (count < 0)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        ASSERT_LT(accepted, max_accepted);
    }
    EXPECT_GT(accepted, 0);
    EXPECT_TRUE(rude.read(stream.size()) == stream);
    Viewer polite(server.port());
    EXPECT_TRUE(polite.read(stream.size()) == stream);
    EXPECT_EQ(server.end_by(SIGTERM), 0);
}

TEST_F(Serving, WhoeverDoesNotReadIsDroppedAndOthersGoOn) {
    const std::string stream = record_large("a.mkv");
    Server server(arguments("a.mkv", {"--patience", "2"}), place());
    Viewer idle(server.port(), 4096);
    Viewer reading(server.port());
    EXPECT_TRUE(reading.read() == stream) << reading.read().size();
    EXPECT_TRUE(comes_true([&] { return server.lines_with("did not read for 2 s") == 1; })) << server.log();
    EXPECT_LT(idle.read().size(), stream.size());
    EXPECT_EQ(server.end_by(SIGTERM), 0);
    EXPECT_NE(server.output().find("dropped 1;"), std::string::npos) << server.output();
}

TEST_F(Serving, WhoeverReadsButStaysBehindIsDropped) {
    const std::string stream = record_large("a.mkv");
    Server server(arguments("a.mkv", {"--patience", "0.5"}), place());
    Viewer slow(server.port(), 4096);
    EXPECT_TRUE(comes_true([&] {
        slow.read(slow.arrivals().empty() ? 100 : std::size_t(slow.arrivals().back().bytes) + 32768);
        return server.lines_with("stayed more than 0.5 s behind") == 1;
    })) << server.log();
    EXPECT_LT(slow.read().size(), stream.size());
    EXPECT_EQ(server.end_by(SIGTERM), 0);
    EXPECT_NE(server.output().find("dropped 1;"), std::string::npos) << server.output();
}

TEST_F(Serving, WhoeverStaysAfterTheEndIsSentAway) {
    const std::string stream = record("a.mkv");
    Server server(arguments("a.mkv", {"--patience", "0.2"}), place());
    Viewer staying(server.port());
    EXPECT_TRUE(staying.read() == stream);
    EXPECT_TRUE(comes_true([&] { return server.lines_with("did not disconnect for 0.2 s after the end") == 1; }))
        << server.log();
}

TEST_F(Serving, MoreViewersThanTheLimitAreRefused) {
    const std::string stream = as_sent_in_a_loop(record("a.mkv"));
    Server server(arguments("a.mkv", {"--viewers", "2", "--loop"}), place());
    Viewer first(server.port()), second(server.port());
    EXPECT_EQ(first.read(1).size(), 1u);
    EXPECT_EQ(second.read(1).size(), 1u);
    EXPECT_EQ(Viewer(server.port()).read().size(), 0u);
    EXPECT_EQ(server.lines_with("refused"), 1) << server.log();
    expect_failure(run("info " + server.url()), 1, "the server closed the connection before sending anything");
    first.leave();
    EXPECT_TRUE(comes_true([&] { return server.lines_with(" left") == 1; })) << server.log();
    EXPECT_TRUE(Viewer(server.port()).read(stream.size()) == stream);
    EXPECT_EQ(server.end_by(SIGTERM), 0);
    EXPECT_NE(server.output().find("viewers served 3, refused 2,"), std::string::npos) << server.output();
}

}  // namespace

// Tiles: viewers get those that they look at.

namespace {

TEST_F(ServingTiles, FewerBytesThanTheFileHasMakeWholeFrames) {
    Server server(arguments("a.mkv"), place());
    Viewer looking(server.port());
    look(looking, 0);
    Viewer silent(server.port()), talking(server.port());
    std::mt19937 random(5);
    std::string garbage(2000, '\0');
    std::ranges::generate(garbage, [&] { return char(random()); });
    auto message = encode_viewer_pose({0, {{0, 0, 1e300}, {1, 0, 0, 0}}, {}});  // a place that is none
    garbage.append(message.begin(), message.end());
    message[4] = 9;  // of a version to come
    say(talking, garbage.append(message.begin(), message.end()) + "EQVM");
    std::thread beside([&] { silent.read(); }), another([&] { talking.read(); });
    looking.read();
    beside.join();
    another.join();
    const Pictures of_looking = sound_pictures_in(looking.read()), of_silent = sound_pictures_in(silent.read());
    for (const std::size_t track : ahead) {
        EXPECT_EQ(of_looking.at(track).size(), 20u) << track;
        EXPECT_EQ(of_silent.at(track).size(), 20u) << track << ": where the recording's head looked";
    }
    for (const std::size_t track : behind)
        EXPECT_EQ(of_looking.at(track).size(), 1u) << track << ": the first";
    EXPECT_LT(looking.read().size(), silent.read().size());
    EXPECT_LT(silent.read().size(), fs::file_size(folder / "a.mkv"));
    EXPECT_TRUE(talking.read() == silent.read()) << "garbage changes nothing";
}

TEST_F(ServingTiles, WhoeverTurnsGetsWhatIsThereWithinTwoFrames) {
    Server server(arguments("a.mkv"), place());
    Viewer viewer(server.port());
    look(viewer, 0);
    std::thread beside([&] { viewer.read(); });
    std::this_thread::sleep_for(std::chrono::milliseconds(1250));  // after frame 12
    look(viewer, 180);
    beside.join();
    const std::string& bytes = viewer.read();
    const Pictures all = sound_pictures_in(bytes);
    const auto lacks = [&](const Arrival& arrival) {
        return arrival.bytes < 20000 || !pictures_in(bytes.substr(0, std::size_t(arrival.bytes)))[0].contains(15);
    };
    const auto arrival = std::ranges::partition_point(viewer.arrivals(), lacks);
    ASSERT_NE(arrival, viewer.arrivals().end());
    Pictures by_then = pictures_in(bytes.substr(0, std::size_t(arrival->bytes)));  // with frame 15
    EXPECT_FALSE(by_then[0].contains(18));
    for (const std::size_t track : behind) {
        for (const std::int64_t index : {8, 11, 13, 15})
            EXPECT_TRUE(by_then[track].contains(index)) << track << ", " << index << ": from the key frame on";
        EXPECT_FALSE(all.at(track).contains(7)) << track;
    }
}

TEST_F(ServingTiles, AFileThatHasGoneRefusesWhoComesLaterAndServesTheOthers) {
    Server server(arguments("a.mkv"), place());
    Viewer first(server.port());
    look(first, 0);
    ASSERT_TRUE(comes_true([&] { return server.lines_with("came") == 1; })) << server.log();
    fs::remove(folder / "a.mkv");
    Viewer late(server.port());
    EXPECT_TRUE(late.read().empty());
    EXPECT_EQ(server.lines_with("refused"), 1) << server.log();
    EXPECT_EQ(pictures_in(first.read())[0].size(), 20u);
    EXPECT_EQ(server.end_by(SIGTERM), 0);
}

}  // namespace
}  // namespace equistream::test
