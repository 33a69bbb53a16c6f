#pragma once
#include <cstdio>
#include <vector>

#include "axode/axode.hpp"
#include "axode/io.hpp"

void print_drive_torques(const char* file) {
  const axode::Model arm = axode::load(file);
  axode::Workspace<> workspace(arm);  // scratch memory, one for each thread

  std::vector<double> q = axode::neutral(arm), v(arm.nv(), 0.5), a(arm.nv(), 1.0), tau(arm.nv());
  q[arm.joint(arm.joint_index("A2")).iq] = 0.8;  // rad
  axode::inverse_dynamics(arm, workspace, q, v, a, tau);

  for (const axode::Joint& joint : arm.joints())
    std::printf("%s %.3f N m\n", joint.name.c_str(), tau[joint.iv]);
}
