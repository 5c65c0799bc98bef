/* SPDX-License-Identifier: BSD-3-Clause */
// The contact force at a point, in C++: ask_model_cpp MODEL VALUE...
#include <signorom.h>

#include <cstdlib>
#include <iomanip>
#include <iostream>
#include <memory>
#include <numeric>
#include <vector>

namespace {
using Model = std::unique_ptr<signorom_model, decltype(&signorom_close)>;
using Context = std::unique_ptr<signorom_context, decltype(&signorom_free_context)>;

int fail(const char *sentence) {
  std::cerr << sentence << '\n';
  return 2;
}
} // namespace

int main(int argc, char **argv) {
  if (argc < 2) return fail("usage: ask_model_cpp MODEL VALUE...");
  signorom_model *opened = nullptr;
  const int code = signorom_open(argv[1], &opened);
  const Model model(opened, signorom_close);
  if (code != SIGNOROM_OK) return fail(signorom_model_message(model.get()));
  signorom_sizes sizes;
  signorom_get_sizes(model.get(), &sizes);
  if (argc - 2 != sizes.n_parameters) return fail("one value for each parameter is needed");
  std::vector<double> point;
  for (int i = 2; i < argc; i++) point.push_back(std::atof(argv[i]));

  signorom_context *created = nullptr;
  const int created_code = signorom_create_context(model.get(), &created);
  const Context context(created, signorom_free_context);
  signorom_answer answer = SIGNOROM_ANSWER;
  std::vector<double> forces(static_cast<std::size_t>(sizes.n_contacts));
  if (created_code != SIGNOROM_OK || signorom_query(context.get(), point.data(), &answer) != SIGNOROM_OK ||
      signorom_get_multipliers(context.get(), forces.data()) != SIGNOROM_OK)
    return fail(signorom_message(context.get()));
  std::cout << "signorom " << signorom_version() << ": contact force " << std::setprecision(12)
            << std::accumulate(forces.begin(), forces.end(), 0.0) << '\n'
            << "error of the displacement " << answer.relative_displacement_bound << '\n';
  return 0;
}
