#pragma once
/// How --help looks, of every program in C++.
#include <memory>

namespace CLI {
class FormatterBase;
}

namespace equistream::cli {

std::shared_ptr<CLI::FormatterBase> help_formatter();

}  // namespace equistream::cli
