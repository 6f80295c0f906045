#pragma once
/// The text of a --settings file, made one that CLI11 reads as it is meant: it cuts values at # and at blanks.
#include <string>

namespace equistream::cli {

/// Lines stay lines. Values lose remarks (# or ; after a blank, outside quotes); those with blanks, commas or # get
/// quotes. Lists in brackets stay. Throws InputError with `file` and the line for a quote that does not end.
std::string settings_for_reader(const std::string& text, const std::string& file);

}  // namespace equistream::cli
