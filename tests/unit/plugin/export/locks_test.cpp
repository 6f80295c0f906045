#include "frame_fixture.h"

#include <equistream/error.h>
#include <equistream/locks.h>

#include <sys/stat.h>

#include <cerrno>

namespace equistream::testing {
namespace {

// The kernel's locks belong to open files, so two within one process exclude each other as two processes do.
class Locks : public FolderTest {};

TEST_F(Locks, a_file_is_opened_as_it_is_by_one_at_a_time) {
    const auto file = folder / "a";
    put_bytes(file, "earlier");
    const int first = open_locked_file(file);
    ASSERT_GE(first, 0);
    EXPECT_EQ(file_bytes(file), "earlier");
    EXPECT_EQ(open_locked_file(file), -1);
    EXPECT_EQ(errno, EWOULDBLOCK);
    std::filesystem::rename(file, folder / "b");
    const int another = open_locked_file(file);
    EXPECT_GE(another, 0) << "the lock went with the file";
    close(first);
    close(another);
    const int again = open_locked_file(folder / "b");
    EXPECT_GE(again, 0) << "closing unlocks";
    close(again);
}

TEST_F(Locks, missing_files_are_made_or_not) {
    EXPECT_EQ(open_locked_file(folder / "a", IfMissing::fail), -1);
    EXPECT_EQ(errno, ENOENT);
    const int made = open_locked_file(folder / "a");
    EXPECT_GE(made, 0);
    close(made);
    EXPECT_TRUE(std::filesystem::exists(folder / "a"));
}

TEST_F(Locks, a_folder_belongs_to_one_at_a_time) {
    {
        const FolderLock first(folder);
        EXPECT_THROW(FolderLock second(folder), InputError);
    }
    EXPECT_NO_THROW(FolderLock third(folder));
    EXPECT_TRUE(std::filesystem::is_empty(folder)) << "nothing is left behind";
}

TEST_F(Locks, unfinished_files_that_are_being_written_stay) {
    const int writing = open_locked_file(folder / ".frame.0001.exr.aside");
    put_bytes(folder / ".frame.0002.exr.aside", "of a killed run");
    remove_unfinished_files(folder);
    EXPECT_TRUE(std::filesystem::exists(folder / ".frame.0001.exr.aside"));
    EXPECT_FALSE(std::filesystem::exists(folder / ".frame.0002.exr.aside"));
    close(writing);
}

TEST_F(Locks, no_symbolic_link_is_followed_and_no_pipe_waited_for) {
    put_bytes(folder / "victim", "mine");
    std::filesystem::create_symlink(folder / "victim", folder / ".a.json.aside");
    EXPECT_EQ(open_locked_file(folder / ".a.json.aside"), -1);
    try {
        write_file_atomically(folder / "a.json", "{}");
        ADD_FAILURE() << "a symbolic link was followed";
    } catch (const WorkError& error) {
        EXPECT_EQ(error.what(), (folder / "a.json").string() + ": cannot be written: " +
                                    (folder / ".a.json.aside").string() + ", a symbolic link, there");
    }
    EXPECT_EQ(file_bytes(folder / "victim"), "mine");
    ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
    EXPECT_EQ(open_locked_file(folder / "pipe"), -1);
}

}  // namespace
}  // namespace equistream::testing
