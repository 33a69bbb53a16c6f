#pragma once
#include <cstdio>
#include <string>
#include <vector>

#include "axode/axode.hpp"
#include "axode/io.hpp"

void print_drive_torques(const char* file) {
  const axode::Model arm = axode::load(file);
  axode::Workspace<> workspace(arm);  // scratch memory, one for each thread

  std::vector<double> q = axode::neutral(arm), v(arm.nv(), 0.5), a(arm.nv(), 1.0), tau(arm.nv());
  q[arm.joint(arm.joint_index("A2")).iq] = 0.8;  // rad
  axode::inverse_dynamics(arm, workspace, q, v, a, tau);

  const std::vector<std::string> names = axode::velocity_names(arm);  // of v, a and tau
  for (std::size_t k = 0; k < tau.size(); ++k) std::printf("%s %.3f N m\n", names[k].c_str(), tau[k]);
}
