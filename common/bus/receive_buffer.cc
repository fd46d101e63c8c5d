#include "common/bus/receive_buffer.h"

#include <sys/socket.h>
#include <unistd.h>

namespace cairn {

int EffectiveReceiveBuffer() {
  const int fd = socket(AF_INET, SOCK_DGRAM, 0);
  if (fd < 0) return 212992;
  int size = kWantedReceiveBuffer;
  setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &size, sizeof size);
  socklen_t length = sizeof size;
  getsockopt(fd, SOL_SOCKET, SO_RCVBUF, &size, &length);
  close(fd);
  return size / 2;  // the kernel reports twice the usable size
}

}  // namespace cairn
