#pragma once
/// What CLI11 has against a command line, in our words.
#include <string>

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace equistream::cli {

std::string explained(const CLI::App& app, const CLI::ParseError& error);

}  // namespace equistream::cli
