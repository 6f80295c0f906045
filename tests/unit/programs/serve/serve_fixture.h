#pragma once
/// equistream-serve as a process, and viewers as plain sockets.
#include <tests/unit/programs/programs_fixture.h>

#include <equistream/elapsed.h>
#include <equistream/text.h>
#include <equistream/viewer_message.h>

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <spawn.h>
#include <sys/socket.h>
#include <unistd.h>

#include <csignal>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <thread>
#include <utility>
#include <vector>

extern char** environ;

namespace equistream::test {

/// Long enough for any machine: only a test that fails waits so long.
inline constexpr double give_up_s = 120;

/// Whether `holds` becomes true.
template <typename Condition>
bool comes_true(const Condition& holds) {
    for (const auto start = Clock::now(); seconds_since(start) < give_up_s;
         std::this_thread::sleep_for(std::chrono::milliseconds(10)))
        if (holds())
            return true;
    return false;
}

class Server {
public:
    /// Starts it; it may still be busy with other things than listening.
    Server(std::vector<std::string> arguments, std::filesystem::path folder) : folder_(std::move(folder)) {
        arguments.insert(arguments.begin(), std::string(EQUISTREAM_BIN) + "/equistream-serve");
        std::vector<char*> argv;
        for (std::string& argument : arguments)
            argv.push_back(argument.data());
        argv.push_back(nullptr);
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        constexpr int flags = O_WRONLY | O_CREAT | O_TRUNC;
        posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out_file().c_str(), flags, 0600);
        posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, log_file().c_str(), flags, 0600);
        EXPECT_EQ(posix_spawn(&process_, argv[0], &actions, nullptr, argv.data(), environ), 0);
        posix_spawn_file_actions_destroy(&actions);
    }
    ~Server() {
        if (process_ > 0) {
            kill(process_, SIGKILL);
            waitpid(process_, nullptr, 0);
        }
    }
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    std::string output() const { return text_of(out_file()); }
    std::string log() const { return text_of(log_file()); }
    int lines_with(const std::string& word) const {
        int count = 0;
        std::istringstream lines(log());
        for (std::string line; std::getline(lines, line);)
            count += line.find(word) != std::string::npos ? 1 : 0;
        return count;
    }

    /// As its first line says, which this waits for.
    std::string url() const {
        const std::string before = "listening on ";
        EXPECT_TRUE(comes_true([&] { return output().find('\n') != std::string::npos; })) << log();
        const std::string line = output().substr(0, output().find('\n'));
        EXPECT_TRUE(line.starts_with(before + "tcp://127.0.0.1:") || line.starts_with(before + "tls://") ||
                    line.starts_with(before + "srt://"))
            << line;
        return line.substr(std::min(line.size(), before.size()));
    }
    std::uint16_t port() const {
        const std::string address = url();
        return static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1)));
    }

    /// Sends the signal and returns the exit status, or minus the signal that ended it.
    int end_by(int signal_number) {
        kill(process_, signal_number);
        return wait();
    }
    int wait() {
        int status = 0;
        waitpid(std::exchange(process_, 0), &status, 0);
        return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    }

private:
    std::string out_file() const { return (folder_ / "server.out").string(); }
    std::string log_file() const { return (folder_ / "server.log").string(); }

    std::filesystem::path folder_;
    pid_t process_ = 0;
};

struct Arrival {
    double elapsed_s;    ///< since before the viewer connected
    std::int64_t bytes;  ///< that had come by then
};

class Viewer {
public:
    explicit Viewer(std::uint16_t port, std::optional<int> receive_buffer_bytes = {}) : start_(Clock::now()) {
        socket_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
        if (receive_buffer_bytes)
            setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &*receive_buffer_bytes, sizeof *receive_buffer_bytes);
        const timeval patience{long(give_up_s), 0};
        setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(port);
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        EXPECT_EQ(connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    }
    ~Viewer() { leave(); }
    Viewer(const Viewer&) = delete;
    Viewer& operator=(const Viewer&) = delete;

    /// Reads until `most` bytes have come, or all there are.
    const std::string& read(std::size_t most = std::size_t(-1)) {
        char block[65536];
        while (got_.size() < most) {
            const ssize_t count = recv(socket_, block, std::min(sizeof block, most - got_.size()), 0);
            if (count <= 0)
                break;
            got_.append(block, std::size_t(count));
            arrivals_.push_back({seconds_since(start_), std::int64_t(got_.size())});
        }
        return got_;
    }
    const std::vector<Arrival>& arrivals() const { return arrivals_; }
    int handle() const { return socket_; }

    void leave() {
        if (socket_ >= 0)
            close(std::exchange(socket_, -1));
    }
    /// The connection is not ended but broken.
    void break_off() {
        const linger at_once{1, 0};
        setsockopt(socket_, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
        leave();
    }

private:
    Clock::time_point start_;
    int socket_ = -1;
    std::string got_;
    std::vector<Arrival> arrivals_;
};

class Serving : public Programs {
protected:
    /// 12 pictures at 30 a second in two tracks, and its bytes.
    std::string record(const std::string& name) const {
        synthetic::write(folder / name, synthetic::small_stream(Codec::h264, true));
        return text_of(folder / name);
    }
    /// With an element at the end that readers skip: more than systems keep for a viewer that does not read.
    std::string record_large(const std::string& name) const {
        constexpr std::uint32_t bytes = 32 << 20;
        std::string stream = record(name);
        const char element[] = {char(0xec), char(0x10 | bytes >> 24), char(bytes >> 16 & 255), char(bytes >> 8 & 255),
                                char(bytes & 255)};
        stream.append(element, sizeof element).append(bytes, '\0');
        std::ofstream(folder / name, std::ios::binary) << stream;
        return stream;
    }
    std::vector<std::string> arguments(const std::string& name, std::vector<std::string> more = {}) const {
        std::vector<std::string> all = {path(name), "--listen", "tcp://:0"};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }
    std::filesystem::path place() const { return folder / "."; }
    static void say(const Viewer& viewer, const std::string& bytes) {
        EXPECT_EQ(send(viewer.handle(), bytes.data(), bytes.size(), MSG_NOSIGNAL), ssize_t(bytes.size()));
    }
};

/// Of a recording of tiles.
class ServingTiles : public Serving {
protected:
    using Pictures = std::map<std::size_t, std::map<std::int64_t, ByteImage>>;  // by track, 0 being main, and frame

    void SetUp() override {
        synthetic::write(folder / "a.mkv", made);
        whole = pictures_in(text_of(folder / "a.mkv"));
    }
    Pictures pictures_in(const std::string& bytes) const {
        std::ofstream(folder / "got.mkv", std::ios::binary) << bytes;
        Pictures pictures;
        StreamReader reader(path("got.mkv"));
        for (DecodedPicture& picture : synthetic::read_all(reader))
            pictures[picture.track][picture.info.value().index] = std::move(picture.rgb);
        return pictures;
    }
    /// All that came are as in the file, and main came whole.
    Pictures sound_pictures_in(const std::string& bytes) const {
        Pictures pictures = pictures_in(bytes);
        for (const auto& [track, of_track] : pictures)
            for (const auto& [index, picture] : of_track)
                EXPECT_TRUE(std::ranges::equal(picture.samples(), whole.at(track).at(index).samples())) << track;
        EXPECT_EQ(pictures[0].size(), 20u);
        return pictures;
    }
    /// Its head is turned to the left by so much, and sees little.
    static void look(const Viewer& viewer, double degrees) {
        const ViewerPose pose{0, {{}, glm::angleAxis(degrees * pi / 180, glm::dvec3(0, 1, 0))}, ViewExtent{0.2, 0.2}};
        const auto message = encode_viewer_pose(pose);
        say(viewer, {message.begin(), message.end()});
    }

    /// 2 s, in which a frame takes longer than machines are busy with other things.
    const synthetic::MadeTiles made{
        .grid = {8, 4}, .pictures = 20, .gop = 8, .first_index = 0, .frames_per_second = 10};
    /// Tracks of the tiles around the horizon.
    const std::set<std::size_t> ahead = {1 + 11, 1 + 12, 1 + 19, 1 + 20}, behind = {1 + 8, 1 + 15, 1 + 16, 1 + 23};
    Pictures whole;
};

}  // namespace equistream::test
