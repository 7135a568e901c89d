// raybundle version: which program this is and what it computes with.

#include <string>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <Eigen/Core>

#include <raybundle/linalg/blas_threads.h>
#include <raybundle/linalg/cpu.h>
#include <raybundle/linalg/parallel.h>
#include <raybundle/tools/commands.h>
#include <raybundle/tools/output.h>
#include <raybundle/tools/report.h>
#include <raybundle/version.h>

// Of <cholmod.h>, which belongs to the library alone: the version that is loaded.
extern "C" int cholmod_l_version(int version[3]);

namespace raybundle::tools {
namespace {

std::string instruction_sets() {
  const auto used = linalg::instruction_set();
  const auto detected = linalg::detected_instruction_set();
  std::string text(linalg::name(used));
  if (used != detected) text += " (this processor has " + std::string(linalg::name(detected)) + ")";
  return text;
}

ExitCode run() {
  int cholmod[3] = {};
  cholmod_l_version(cholmod);
  Table table;
  table.add("build", build_description);
  table.add("kernels", instruction_sets());
  table.add("cores", std::to_string(linalg::available_threads()));
  table.add("CHOLMOD", format("%d.%d.%d", cholmod[0], cholmod[1], cholmod[2]));
  table.add("BLAS", linalg::blas_name());
  table.add("Eigen",
            format("%d.%d.%d", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION));
  print(std::string("raybundle ") + version + "\n" + table.text());
  return ExitCode::usable;
}

}  // namespace

Command add_version(CLI::App& program) {
  return {program.add_subcommand("version", "Which raybundle this is, and what it computes with"),
          run};
}

}  // namespace raybundle::tools
