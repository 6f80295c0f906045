/// A renderer that does not do what it should, played by a shell: the server hears of it in time, and ends it.
#include <programs/serve/children.h>

#include <equistream/elapsed.h>

#include <asio/io_context.hpp>
#include <gtest/gtest.h>

#include <exception>
#include <string>

namespace equistream::serve {
namespace {

/// What such a script fails for.
std::string failure_of(const std::string& script) {
    asio::io_context io;
    std::exception_ptr problem;
    const RenderChild child(io, "/bin/sh", {"-c", script},
                            {[](double) {}, [](const RenderedFrame&) {}, [&](std::exception_ptr p) { problem = p; }});
    io.run_for(std::chrono::seconds(60));
    if (!problem)
        return "none";
    try {
        std::rethrow_exception(problem);
    } catch (const std::exception& error) {
        return error.what();
    }
}

TEST(RenderChildren, AnAnswerWithoutEndIsNotWaitedFor) {
    const auto start = Clock::now();
    EXPECT_EQ(failure_of("head -c 70000 /dev/zero | tr '\\0' x; exec sleep 1000"),
              "/bin/sh: expected answers of at most 65536 bytes, found a longer one");
    EXPECT_LT(seconds_since(start), 50);
}

TEST(RenderChildren, OneThatFallsSilentAndDoesNotEndIsKilled) {
    const auto start = Clock::now();
    EXPECT_EQ(failure_of("exec sleep 1000 >/dev/null"), "/bin/sh: was ended by signal 9");
    EXPECT_LT(seconds_since(start), 50);
}

TEST(RenderChildren, OneThatEndsByItselfSaysNoMore) {
    EXPECT_EQ(failure_of("exit 0"), "/bin/sh: has ended by itself");
}

}  // namespace
}  // namespace equistream::serve
