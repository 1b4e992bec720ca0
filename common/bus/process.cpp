#include "common/bus/process.h"

#include <csignal>
#include <cstdlib>

#ifdef __linux__
#include <sys/prctl.h>
#endif

namespace heartbus::bus {
namespace {

/// Open MPI hands larger messages over in stages for which the sender has to be awake, unless one process may read the
/// other's memory, which many systems forbid (ptrace_scope). By default they begin at 4 kB.
void keep_messages_whole() {
  constexpr char size[] = "65536"; // bytes
  setenv("OMPI_MCA_btl_vader_eager_limit", size, 0);
  setenv("OMPI_MCA_btl_vader_max_send_size", size, 0);
}

} // namespace

void settle_process(bool is_coupler) {
  // The launcher forwards SIGUSR1 to every rank, and by default it ends a process.
  if (!is_coupler)
    std::signal(SIGUSR1, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN); // a file beyond the user's limit is for its writer to report, as a full disk is
  keep_messages_whole();
#ifdef __linux__
  prctl(PR_SET_TIMERSLACK, 1000); // [ns]: a pause takes as long as it says, not 50 us longer
#endif
}

} // namespace heartbus::bus
