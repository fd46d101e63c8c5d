package cairn.spy;

import cairn_lcm.actor_telemetry_t;
import cairn_lcm.learner_telemetry_t;
import java.awt.GridLayout;
import java.io.IOException;
import java.util.Locale;
import javax.swing.JPanel;
import javax.swing.SwingUtilities;
import lcm.lcm.LCM;
import lcm.lcm.LCMDataInputStream;
import lcm.lcm.LCMSubscriber;

/**
 * Four plots of a run: success, consumption, rates and policy lag, the last two for each actor. Listens to the telemetry
 * plane itself (LCM_DEFAULT_URL, as lcm-spy does), since a plug-in is only told of the channel that was clicked.
 */
class RunPanel extends JPanel implements LCMSubscriber {
  private static final String LEARNER = "CAIRN_LEARNER";
  private static final int CONSUMPTION_STARTS = 10;

  private final LivePlot success = new LivePlot("Success", 1);
  private final LivePlot consumption = new LivePlot("Consumption starts solved", CONSUMPTION_STARTS);
  private final LivePlot rates = new LivePlot("Env steps a second", 0);
  private final LivePlot lag = new LivePlot("Policy lag, versions", 0);

  // Of the newest learner message.
  private boolean learnerHeard = false;
  private double wallSeconds;
  private long version;
  private long receivedNanos;

  RunPanel() {
    super(new GridLayout(2, 2));
    for (LivePlot plot : new LivePlot[] {success, consumption, rates, lag}) add(plot);
    LCM.getSingleton().subscribe(LEARNER, this);
    LCM.getSingleton().subscribe("CAIRN_ACTOR_.*", this);
  }

  /** On LCM's thread. A message of another version of the type is passed over, as lcm-spy does. */
  @Override
  public void messageReceived(LCM lcm, String channel, LCMDataInputStream in) {
    try {
      if (channel.equals(LEARNER)) {
        learner_telemetry_t message = new learner_telemetry_t(in);
        SwingUtilities.invokeLater(() -> show(message));
      } else {
        actor_telemetry_t message = new actor_telemetry_t(in);
        SwingUtilities.invokeLater(() -> show(message));
      }
    } catch (IOException other) {
      // Not our type.
    }
  }

  private void show(learner_telemetry_t m) {
    learnerHeard = true;
    wallSeconds = m.wall_s;
    version = m.policy_version;
    receivedNanos = System.nanoTime();
    success.add("validation", m.wall_s, m.success_rate);
    success.add("training", m.wall_s, m.training_success_rate);
    success.say(format("%.1f %%, %s", 100 * m.success_rate, m.phase));
    if (m.consumption_solved >= 0) consumption.add("newest check", m.wall_s, m.consumption_solved);
    consumption.say(
        m.consumption_env_steps < 0
            ? "not all ten yet"
            : format("all ten after %,d env steps", m.consumption_env_steps));
    rates.add("learner", m.wall_s, m.env_steps_per_s);
    rates.say(format("%,.0f, and %,.0f updates", m.env_steps_per_s, m.updates_per_s));
    lag.add("mean in training", m.wall_s, m.policy_lag);
    lag.say(format("%.2f in the mean, version %d", m.policy_lag, m.policy_version));
  }

  private void show(actor_telemetry_t m) {
    if (!learnerHeard) return; // no time to put it at yet
    double seconds = wallSeconds + 1e-9 * (System.nanoTime() - receivedNanos);
    String name = format("actor %d", m.actor_id);
    rates.add(name, seconds, m.env_steps_per_s);
    lag.add(name, seconds, Math.max(0, version - m.policy_version));
  }

  private static String format(String pattern, Object... values) {
    return String.format(Locale.ROOT, pattern, values);
  }
}
