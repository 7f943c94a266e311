// SPDX-License-Identifier: Apache-2.0
// The program `kestrel-worker`, the far side of the pool's wire: flies what comes on standard input until it
// ends, and answers on what was standard output. A program of its own, since a flight has no use for the
// library of the searches, which alone takes 34 MB.
#include <fcntl.h>
#include <fmt/format.h>
#include <malloc.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <opencv2/core/utility.hpp>
#include <string>

#include "app/run/isa_option.h"
#include "base/process/print_note.h"
#include "base/version.h"
#include "campaign/execution/fly_row.h"
#include "campaign/execution/worker_wire.h"
#include "flight/load_plugins.h"

namespace kestrel::app {
namespace {

bool WriteAll(int file, const std::string& text) {
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t n = write(file, text.data() + done, text.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    done += static_cast<std::size_t>(n);
  }
  return true;
}

int Work() {
  cv::setNumThreads(1);
  prctl(PR_SET_NAME, "kestrel-worker");  // it was started by a descriptor, which is what lists would show
  // The wire is for orders and reports alone: what else reads or prints, here or in programs that a flight
  // starts, has no part in it.
  const int orders = fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 3);
  const int reports = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 3);
  const int nothing = open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (orders < 0 || reports < 0 || nothing < 0) return 3;
  dup2(nothing, STDIN_FILENO);
  dup2(STDERR_FILENO, STDOUT_FILENO);
  close(nothing);

#ifdef __GLIBC__
  // What is larger than the images of a frame, as textures on their way to the renderer and what a search for
  // the pad takes, is given back at once; but what each frame takes anew is kept until the flight is over, for to
  // give it back and take it again cost a tenth of the time.
  mallopt(M_MMAP_THRESHOLD, 1 << 22);
  mallopt(M_TRIM_THRESHOLD, 1 << 24);
#endif

  if (!WriteAll(reports, campaign::kGreetingLine)) return 3;
  std::string received;
  for (;;) {
    for (std::size_t end; (end = received.find('\n')) != std::string::npos; received.erase(0, end + 1)) {
      const campaign::RunResult result = campaign::FlyRow(campaign::OrderOf(received.substr(0, end)));
      std::fflush(nullptr);
      if (!WriteAll(reports, campaign::ReportLine(result))) return 3;
    }
    char bytes[4096];
    const ssize_t n = read(orders, bytes, sizeof bytes);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return n == 0 ? 0 : 3;
    received.append(bytes, static_cast<std::size_t>(n));
  }
}

}  // namespace
}  // namespace kestrel::app

int main(int argc, char** argv) {
  if (argc != 2 || std::string(argv[1]) != kestrel::Version()) {
    fmt::print(stderr, "kestrel-worker is started by kestrel of the same version, which is {}: build both\n",
               kestrel::Version());
    return 2;
  }
  kestrel::app::GoByTheEnvironment();
  try {
    kestrel::flight::LoadPlugins({});  // which KESTREL_PLUGINS names, as kestrel has set it
  } catch (const std::exception& e) {
    kestrel::PrintNote("{}\n", e.what());
    return 2;
  }
  return kestrel::app::Work();
}
