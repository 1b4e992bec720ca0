#pragma once

namespace heartbus::bus {

/// What our own programs do with the process that is theirs alone, before MPI is initialised; a library within another
/// program leaves that one's process as it is. Signals that would end a rank which is to end with the others are
/// ignored, messages stay whole, and a pause takes as long as it says.
void settle_process(bool is_coupler);

} // namespace heartbus::bus
