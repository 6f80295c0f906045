#pragma once
/// Programs of ours that must not share a process with Mitsuba.
#include <string>
#include <vector>

namespace equistream::mitsuba_host {

/// Runs the program of this name that lies beside this one and returns what it wrote to standard output. Where it
/// fails, throws what it said on standard error: an InputError if it calls the input bad (exit status 2), else a
/// WorkError.
std::string run_beside(const std::string& program, const std::vector<std::string>& arguments);

}  // namespace equistream::mitsuba_host
