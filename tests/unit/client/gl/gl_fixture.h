#pragma once
/// A context without a window for every test, whose driver's complaints end the test program.
#include <client/gpu/context.h>

#include <gtest/gtest.h>

#include <memory>

namespace equistream::test {

class Gl : public testing::Test {
protected:
    static void SetUpTestSuite() {
        gl::abort_on_errors();
        context = gl::make_offscreen_context();
    }
    static void TearDownTestSuite() { context.reset(); }

    static inline std::unique_ptr<gl::Context> context;
};

}  // namespace equistream::test
