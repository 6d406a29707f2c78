// Holds contracts against samples. Reads lines "contract pad share samples" (pad -1: none is changed) and answers each with one line: for every variant that
// has the contract, its number and how many samples it took to break it, -1 where none did.
#include <cstdio>
#include <cstring>

#include "kernel_host.h"

Random random_numbers;
double pad_shares[1024];
int error_mode = 0;
Contract* Contract::first = nullptr;

int main() {
  for (double& share : pad_shares) share = 1;
  char name[256];
  int pad, samples;
  double share;
  while (std::scanf("%255s %d %lf %d", name, &pad, &share, &samples) == 4) {
    if (pad >= 0) pad_shares[pad] = share;
    for (const Contract* c = Contract::first; c; c = c->next) {
      if (std::strcmp(c->name, name) != 0) continue;
      random_numbers.state = 1;
      int broken = -1;
      for (int i = 0; i < samples && broken < 0; ++i) {
        error_mode = i % 3 - 1;
        if (!c->sample(random_numbers)) broken = i;
      }
      std::printf("%d %d ", c->variant, broken);
    }
    std::printf("\n");
    std::fflush(stdout);
    if (pad >= 0) pad_shares[pad] = 1;
  }
}
