// One motion in four representations, side by side: the twist of a tool and its rate.
#include <cstdio>
#include <vector>

#include "axode/axode.hpp"
#include "axode/eigen.hpp"
#include "axode/io.hpp"

using namespace axode;

int main(int argc, char** argv) {
  const Model model = load(argc > 1 ? argv[1] : AXODE_ROBOTS_DIR "/arm7.toml");
  const int tool = model.n_frames() - 1;
  Workspace<> workspace(model);
  const std::vector<double> q = random_configuration(model, 2), v(model.nv(), 0.5), a(model.nv(), -0.2);

  Eigen::Matrix<double, 12, 4> table;  // V and V', one column for each representation
  const auto fill = [&]<class Rep>(int column, Rep) {
    std::vector<Twist<Rep>> V(model.n_frames());
    std::vector<TwistRate<Rep>> dV(model.n_frames());
    twists<Rep>(model, workspace, q, v, V);
    accelerations<Rep>(model, workspace, q, v, a, dV);
    table.col(column) << to_eigen(V[tool]), to_eigen(dV[tool]);
  };
  fill(0, BodyFixed{}), fill(1, Spatial{}), fill(2, Hybrid{}), fill(3, Mixed{});

  const char* rows[] = {"w_x",  "w_y",  "w_z",  "v_x",  "v_y",  "v_z",
                        "w'_x", "w'_y", "w'_z", "v'_x", "v'_y", "v'_z"};
  std::printf("%s\n      %10s %10s %10s %10s\n", model.frame(tool).name.c_str(), "body", "spatial", "hybrid",
              "mixed");
  for (int k = 0; k < 12; ++k)
    std::printf("%5s %10.5f %10.5f %10.5f %10.5f\n", rows[k], table(k, 0), table(k, 1), table(k, 2),
                table(k, 3));
}
