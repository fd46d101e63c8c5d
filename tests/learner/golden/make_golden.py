#!/usr/bin/env python3
"""Remakes the golden files: 20 consecutive updates of SAC and TD3 by PyTorch in float64.

    apt-get install -y --no-install-recommends python3-torch    # Debian 12: PyTorch 1.13
    /usr/bin/python3 tests/learner/golden/make_golden.py

Written with torch.nn, autograd and torch.optim alone, from the papers: Haarnoja et al. 2018 (arXiv:1812.05905,
algorithm 1) and Fujimoto et al. 2018 (algorithm 1). golden_test.cc reads the files; tests never run this script.

A file is lines `name value value …`. `batches.txt` holds the transitions and the noise, which all cases share; every
value there and every initial weight is a multiple of a small power of two, so that float and double start from the
same numbers. `<case>.txt` holds the settings, the initial networks, the losses of each update and all weights after
some of them. Weights W [out × in] stand column-major, as the learner keeps them.
"""

import os

import torch
from torch import nn

torch.set_default_dtype(torch.float64)
torch.manual_seed(20)

HERE = os.path.dirname(os.path.abspath(__file__))
OBSERVATIONS, ACTIONS, WIDTH, BATCH, UPDATES = 5, 2, 16, 32, 20
SNAPSHOTS = (1, 10, 20)  # weights are written after these
SETTINGS = dict(learning_rate=0.003, tau=0.02, initial_alpha=0.25, target_entropy=-2.0, policy_delay=2,
                target_policy_noise=0.25, target_noise_clip=0.375)
# The cases with LayerNorm clip gradients too: their norms are 0.1 to 6.
CASES = {"sac": (False, 0.0), "sac_layer_norm": (True, 0.75), "td3": (False, 0.0), "td3_layer_norm": (True, 0.75)}


def quantised(tensor, steps):
    return torch.round(tensor * steps) / steps


class Writer:
    def __init__(self, name):
        self.file = open(os.path.join(HERE, name + ".txt"), "w", encoding="ascii")

    def write(self, name, values):
        values = torch.as_tensor(values).detach().reshape(-1).tolist()
        self.file.write(name + " " + " ".join(repr(v).removesuffix(".0") for v in values) + "\n")


class Batch:
    def __init__(self):
        normal = lambda *shape: quantised(torch.randn(*shape), 256)
        self.observation = normal(BATCH, OBSERVATIONS)
        self.action = quantised(2 * torch.rand(BATCH, ACTIONS) - 1, 256)
        self.reward = normal(BATCH)
        self.discount = torch.where(torch.rand(BATCH) < 0.2, torch.zeros(BATCH), torch.full((BATCH,), 0.96875))
        self.next_observation = normal(BATCH, OBSERVATIONS)
        self.noise = normal(BATCH, ACTIONS)
        self.next_noise = normal(BATCH, ACTIONS)


class Mlp(nn.Module):
    def __init__(self, inputs, outputs, layer_norm):
        super().__init__()
        layers = []
        for size in (inputs, WIDTH):
            layers += [nn.Linear(size, WIDTH)] + ([nn.LayerNorm(WIDTH)] if layer_norm else []) + [nn.ReLU()]
        self.net = nn.Sequential(*layers, nn.Linear(WIDTH, outputs))
        with torch.no_grad():
            for module in self.net:
                if isinstance(module, nn.LayerNorm):  # gains and offsets that a mistake would show in
                    module.weight += 0.25 * torch.randn(WIDTH)
                    module.bias += 0.25 * torch.randn(WIDTH)
            for parameter in self.parameters():
                parameter.copy_(quantised(parameter, 4096))

    def forward(self, *inputs):
        return self.net(torch.cat(inputs, dim=1))

    def follow(self, online, tau):
        with torch.no_grad():
            for target, parameter in zip(self.parameters(), online.parameters()):
                target.copy_((1 - tau) * target + tau * parameter)

    def tensors(self):
        """(name, values) in the learner's order: per layer W column-major, b, and gain, offset of LayerNorm."""
        layer = -1
        for module in self.net:
            if isinstance(module, nn.Linear):
                layer += 1
                yield f"{layer}/weights", module.weight.t().contiguous()
                yield f"{layer}/bias", module.bias
            if isinstance(module, nn.LayerNorm):
                yield f"{layer}/gain", module.weight
                yield f"{layer}/offset", module.bias


class Learner:
    def __init__(self, policy_outputs, layer_norm, max_grad_norm):
        def critic():
            mlp = Mlp(OBSERVATIONS + ACTIONS, 1, layer_norm)
            with torch.no_grad():
                mlp.net[-1].bias += 1  # keeps the actor's loss away from 0, where a relative difference means little
            return mlp

        self.max_grad_norm = max_grad_norm
        # The targets start elsewhere than the networks they follow: a mix-up shows at once.
        self.networks = {"policy": Mlp(OBSERVATIONS, policy_outputs, layer_norm), "q1": critic(), "q2": critic(),
                         "target_q1": critic(), "target_q2": critic()}
        self.policy, self.q1, self.q2, self.target_q1, self.target_q2 = self.networks.values()
        adam = lambda *networks: torch.optim.Adam(
            [p for n in networks for p in n.parameters()], lr=SETTINGS["learning_rate"])
        self.policy_adam, self.critic_adam = adam(self.policy), adam(self.q1, self.q2)

    def step(self, adam, loss):
        adam.zero_grad()
        loss.backward()
        if self.max_grad_norm > 0:
            nn.utils.clip_grad_norm_(adam.param_groups[0]["params"], self.max_grad_norm)
        adam.step()

    def write_weights(self, writer, prefix):
        for network, mlp in self.networks.items():
            for name, values in mlp.tensors():
                writer.write(f"{prefix}/{network}/{name}", values)


class Sac(Learner):
    def __init__(self, layer_norm, max_grad_norm):
        super().__init__(2 * ACTIONS, layer_norm, max_grad_norm)
        self.log_alpha = torch.tensor(SETTINGS["initial_alpha"]).log().requires_grad_()
        self.alpha_adam = torch.optim.Adam([self.log_alpha], lr=SETTINGS["learning_rate"])

    def sample(self, observation, noise):
        mean, log_std = self.policy(observation).chunk(2, dim=1)
        log_std = log_std.clamp(-20, 2)
        gaussian = torch.distributions.Normal(mean, log_std.exp())
        u = mean + log_std.exp() * noise
        # log(1 − tanh² u) = 2 (log 2 − u − softplus(−2 u))
        squash = 2 * (torch.log(torch.tensor(2.0)) - u - nn.functional.softplus(-2 * u))
        return torch.tanh(u), (gaussian.log_prob(u) - squash).sum(dim=1)

    def update(self, batch, _):
        alpha = self.log_alpha.exp().detach()
        with torch.no_grad():
            action, log_prob = self.sample(batch.next_observation, batch.next_noise)
            next_q = torch.min(self.target_q1(batch.next_observation, action),
                               self.target_q2(batch.next_observation, action))[:, 0]
            y = batch.reward + batch.discount * (next_q - alpha * log_prob)
        critic_loss = sum(0.5 * ((q(batch.observation, batch.action)[:, 0] - y) ** 2).mean() for q in (self.q1, self.q2))
        self.step(self.critic_adam, critic_loss)

        action, log_prob = self.sample(batch.observation, batch.noise)
        q = torch.min(self.q1(batch.observation, action), self.q2(batch.observation, action))[:, 0]
        actor_loss = (alpha * log_prob - q).mean()
        self.step(self.policy_adam, actor_loss)

        alpha_loss = -(self.log_alpha * (log_prob.detach() + SETTINGS["target_entropy"])).mean()
        self.alpha_adam.zero_grad()
        alpha_loss.backward()
        self.alpha_adam.step()

        self.target_q1.follow(self.q1, SETTINGS["tau"])
        self.target_q2.follow(self.q2, SETTINGS["tau"])
        return critic_loss, actor_loss, alpha_loss, self.log_alpha.exp()


class Td3(Learner):
    def __init__(self, layer_norm, max_grad_norm):
        super().__init__(ACTIONS, layer_norm, max_grad_norm)
        self.networks["target_policy"] = self.target_policy = Mlp(OBSERVATIONS, ACTIONS, layer_norm)

    def update(self, batch, number):
        limit = SETTINGS["target_noise_clip"]
        with torch.no_grad():
            noise = (SETTINGS["target_policy_noise"] * batch.next_noise).clamp(-limit, limit)
            action = (torch.tanh(self.target_policy(batch.next_observation)) + noise).clamp(-1, 1)
            next_q = torch.min(self.target_q1(batch.next_observation, action),
                               self.target_q2(batch.next_observation, action))[:, 0]
            y = batch.reward + batch.discount * next_q
        critic_loss = sum(nn.functional.mse_loss(q(batch.observation, batch.action)[:, 0], y)
                          for q in (self.q1, self.q2))
        self.step(self.critic_adam, critic_loss)
        if number % SETTINGS["policy_delay"] != 0:
            return (critic_loss,)

        actor_loss = -self.q1(batch.observation, torch.tanh(self.policy(batch.observation))).mean()
        self.step(self.policy_adam, actor_loss)
        for target, online in ((self.target_q1, self.q1), (self.target_q2, self.q2),
                               (self.target_policy, self.policy)):
            target.follow(online, SETTINGS["tau"])
        return critic_loss, actor_loss


def main():
    batches = [Batch() for _ in range(UPDATES)]
    writer = Writer("batches")
    for number, batch in enumerate(batches, start=1):
        for name, values in vars(batch).items():
            writer.write(f"{number}/{name}", values)
    for case, (layer_norm, max_grad_norm) in CASES.items():
        learner = (Sac if case.startswith("sac") else Td3)(layer_norm, max_grad_norm)
        writer = Writer(case)
        for name, value in dict(SETTINGS, layer_norm=float(layer_norm), max_grad_norm=max_grad_norm).items():
            writer.write(name, value)
        learner.write_weights(writer, "0")
        for number, batch in enumerate(batches, start=1):
            writer.write(f"{number}/losses", torch.stack([v.detach() for v in learner.update(batch, number)]))
            if number in SNAPSHOTS:
                learner.write_weights(writer, str(number))


if __name__ == "__main__":
    main()
