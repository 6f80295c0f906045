#pragma once
/// Which code this program was built from.
namespace equistream {

/// Eight hexadecimal digits over the sources that decide pixels, as each host lists them
/// (cmake/CodeIdentity.cmake).
const char* code_identity();

}  // namespace equistream
