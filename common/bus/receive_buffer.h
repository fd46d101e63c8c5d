#pragma once

namespace cairn {

/// Receive buffer that every plane asks the kernel for [bytes]: with its default of 212 kB every second message of
/// 190 kB is lost.
constexpr int kWantedReceiveBuffer = 4000000;

/// What the kernel gives a socket that asks for it [bytes]: less where net.core.rmem_max is smaller.
int EffectiveReceiveBuffer();

}  // namespace cairn
