#pragma once
/// What the driver reports, as abort_on_errors (context.h) wants it.
namespace equistream::gl {

/// Whether contexts that are made now shall be debug contexts and be watched.
bool errors_abort();
/// Watches the current context.
void watch_errors();

}  // namespace equistream::gl
