#pragma once

namespace equistream::cli {

/// Thrown where another program of ours, run as a child, has failed and said why: run_program says nothing more.
struct ChildFailed {
    int exit_code;
};

}  // namespace equistream::cli
