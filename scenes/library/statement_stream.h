#pragma once
/// Feeds tinyobjloader one statement at a time, so that its callbacks run while the line they stem from is the last one
/// that was handed over.
#include <functional>
#include <istream>
#include <optional>
#include <streambuf>
#include <string>
#include <utility>

namespace equistream {

/// Gives a statement without its line end, or nothing at the end of the file; may throw.
using NextStatement = std::function<std::optional<std::string>()>;

class StatementBuffer : public std::streambuf {
public:
    explicit StatementBuffer(NextStatement next) : next_(std::move(next)) {}

private:
    int_type underflow() override {
        std::optional<std::string> statement = next_();
        if (!statement)
            return traits_type::eof();
        text_ = std::move(*statement) + "\n";
        setg(text_.data(), text_.data(), text_.data() + text_.size());
        return traits_type::to_int_type(text_.front());
    }

    NextStatement next_;
    std::string text_;
};

class StatementStream : public std::istream {
public:
    explicit StatementStream(NextStatement next) : std::istream(nullptr), buffer_(std::move(next)) {
        rdbuf(&buffer_);
        exceptions(std::ios::badbit);  // hands on what the buffer throws
    }

private:
    StatementBuffer buffer_;
};

}  // namespace equistream
