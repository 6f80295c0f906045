/// Where programs lie, and how processes end.
#include <programs/cli/process.h>
#include <programs/cli/program.h>

#include <gtest/gtest.h>

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <new>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace equistream::cli {
namespace {

TEST(Process, FindsItsFolderWithoutProcToo) {
    EXPECT_TRUE(own_folder().is_absolute());
    EXPECT_EQ(own_folder("/no/such/link"), own_folder());
}

/// The folder that a process makes, fills and leaves to a signal.
class InterruptedScratch : public testing::TestWithParam<int> {};

TEST_P(InterruptedScratch, IsRemovedAndTheSignalEndsTheProcess) {
    int ends[2];
    ASSERT_EQ(pipe(ends), 0);
    const pid_t child = fork();
    if (child == 0) {
        const ScratchFolder folder("test"), another("test");
        std::filesystem::create_directory(folder.path() / "inner");
        std::ofstream(folder.file("inner/a")) << "bytes";
        const std::string names = folder.path().string() + "\n" + another.path().string() + "\n";
        if (write(ends[1], names.data(), names.size()) != static_cast<ssize_t>(names.size()))
            _exit(1);
        for (;;)
            pause();
    }
    std::string names;
    while (std::count(names.begin(), names.end(), '\n') < 2) {
        char c = 0;
        ASSERT_EQ(read(ends[0], &c, 1), 1);
        names += c;
    }
    close(ends[0]);
    close(ends[1]);
    kill(child, GetParam());
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == GetParam()) << status;
    std::istringstream lines(names);
    for (std::string name; std::getline(lines, name);)
        EXPECT_FALSE(std::filesystem::exists(name)) << name;
}

/// How a process ends that does this.
int status_of(const std::function<void()>& work) {
    const pid_t child = fork();
    if (child == 0) {
        work();
        _exit(0);
    }
    int status = 0;
    EXPECT_EQ(waitpid(child, &status, 0), child);
    return status;
}

/// The same, and what it says on standard error.
std::pair<int, std::string> end_of(const std::function<void()>& work) {
    int ends[2] = {-1, -1};
    EXPECT_EQ(pipe(ends), 0);
    const int status = status_of([&] {
        dup2(ends[1], STDERR_FILENO);
        work();
    });
    close(ends[1]);
    std::string said(100, '\0');
    said.resize(std::size_t(std::max<ssize_t>(0, read(ends[0], said.data(), said.size()))));
    close(ends[0]);
    return {status, said};
}

/// The handler is called as `new` calls it: sanitizers have a `new` of their own.
TEST(Memory, ThatIsNotThereEndsTheProcess) {
    const auto [status, said] = end_of([] {
        end_where_memory_ends("test");
        std::thread([] {
            if (const std::new_handler handler = std::get_new_handler())
                handler();
        }).join();
    });
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == exit_failed) << status;
    EXPECT_EQ(said, "equistream test: out of memory\n");
}

TEST(Interrupts, EndTheProcessWithALine) {
    const auto [status, said] = end_of([] {
        std::signal(SIGINT, SIG_DFL);
        say_at_interrupt("equistream test: interrupted: nothing is written");
        kill(getpid(), SIGINT);
        for (;;)
            pause();
    });
    EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGINT) << status;
    EXPECT_EQ(said, "equistream test: interrupted: nothing is written\n");
}

TEST(Interrupts, AreNotedOnceAndEndItThen) {
    const int status = status_of([] {
        std::signal(SIGTERM, SIG_DFL);
        note_interrupts();
        if (interrupted())
            _exit(1);
        raise(SIGTERM);
        if (!interrupted())
            _exit(2);
        raise(SIGTERM);
    });
    EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGTERM) << status;
}

/// A shell starts what runs in the background so.
TEST(Interrupts, ThatAreIgnoredStaySo) {
    const int status = status_of([] {
        std::signal(SIGINT, SIG_IGN);
        say_at_interrupt("interrupted");
        raise(SIGINT);
        note_interrupts();
        raise(SIGINT);
        if (interrupted())
            _exit(1);
    });
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
}

INSTANTIATE_TEST_SUITE_P(Signals, InterruptedScratch, testing::Values(SIGINT, SIGTERM, SIGHUP));

}  // namespace
}  // namespace equistream::cli
