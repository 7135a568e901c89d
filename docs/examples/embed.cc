// Bundle adjustment inside another program: solves a BAL file, or a generated street when no file
// is named, and stops as soon as an accepted step lowers the cost by less than one per cent.
//
//   embed [problem.txt]

#include <cstdio>
#include <exception>

#include <raybundle/models/io/bal.h>
#include <raybundle/models/scenes/street.h>
#include <raybundle/models/statistics.h>
#include <raybundle/solver/solve.h>
#include <raybundle/version.h>

namespace {

// An observer is called after every iteration, iteration 0 being the start.
class StopWhenSlow {
 public:
  raybundle::Control operator()(const raybundle::IterationRecord& record) {
    const double previous = cost_;
    cost_ = record.cost;
    if (record.iteration == 0 || !record.accepted) return raybundle::Control::proceed;
    const bool slow = previous - record.cost < 0.01 * previous;
    return slow ? raybundle::Control::stop : raybundle::Control::proceed;
  }

 private:
  double cost_ = 0;
};

int run(int argc, char** argv) {
  raybundle::Problem problem =
      argc > 1 ? raybundle::io::read_bal(argv[1]) : raybundle::scenes::street();
  const double rmse_before = raybundle::reprojection_statistics(problem).rmse;

  const raybundle::Summary summary = raybundle::solve(
      problem, {.method = raybundle::Method::lm_cholesky, .max_iterations = 50}, StopWhenSlow{});

  const double rmse_after = raybundle::reprojection_statistics(problem).rmse;
  std::printf("raybundle %s (%s)\n", raybundle::version, raybundle::build_description);
  std::printf("%zu iterations, ended by %s: %s\n", summary.iterations.size() - 1,
              raybundle::name(summary.termination), summary.message.c_str());
  std::printf("cost %.6e -> %.6e, RMSE %.4f -> %.4f pixels\n", summary.initial_cost,
              summary.final_cost, rmse_before, rmse_after);
  return summary.usable() && summary.final_cost < summary.initial_cost ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {  // InputError says file and line
    std::fprintf(stderr, "embed: %s\n", error.what());
    return 2;
  }
}
