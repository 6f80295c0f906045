#pragma once
/// Reading a pipe so that whoever waits for its bytes can be asked to give up.
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace equistream {

/// Of the addresses of pipes that are open already.
inline constexpr std::string_view pipe_scheme = "pipe:";

class Pipe {
public:
    /// Of pipe:, which is standard input, pipe:NUMBER of an open descriptor, or a named pipe. Null: it is none of them.
    /// Throws InputError.
    static std::unique_ptr<Pipe> open(const std::string& name);
    ~Pipe();
    Pipe(const Pipe&) = delete;
    Pipe& operator=(const Pipe&) = delete;

    /// The number of bytes that came, or libav's code of the end, of having been interrupted or of a failure.
    int read(std::span<std::uint8_t> bytes, const std::function<bool()>& interrupted) const;

private:
    Pipe(int descriptor, bool is_ours) : descriptor_(descriptor), is_ours_(is_ours) {}

    int descriptor_;
    bool is_ours_;  ///< to close
};

}  // namespace equistream
