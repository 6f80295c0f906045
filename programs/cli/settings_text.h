#pragma once
/// The text of a --settings file, made one that CLI11 reads as it is meant: it cuts values at # and at blanks.
#include <string>

namespace equistream::cli {

/// Without the byte order mark (EF BB BF) that some editors put in front of UTF-8.
std::string without_byte_order_mark(const std::string& text);

/// Lines stay lines. They lose remarks: a # at the beginning or after a blank, outside quotes. Values with blanks,
/// commas or # get quotes. Lists in brackets stay. Throws InputError with `file` and the line for values whose quotes
/// do not end, or are of both kinds within.
std::string settings_for_reader(const std::string& text, const std::string& file);

}  // namespace equistream::cli
