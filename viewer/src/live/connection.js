// SPDX-License-Identifier: MIT

const kFirstWait_ms = 500,
  kLongestWait_ms = 5000;

/**
 * The connection to the run, made again when it ends. Text is JSON, the rest is bytes.
 * @param {{opened: () => void, closed: (reason: string) => void, told: (message: any) => void,
 *   bytes: (bytes: Uint8Array) => void}} events
 */
export function connect(events) {
  const address = new URL("socket", location.href);
  address.protocol = "ws:";
  let socket = null;
  let wait_ms = kFirstWait_ms;

  const open = () => {
    socket = new WebSocket(address);
    socket.binaryType = "arraybuffer";
    socket.addEventListener("open", () => {
      wait_ms = kFirstWait_ms;
      events.opened();
    });
    socket.addEventListener("message", ({ data }) => {
      if (typeof data === "string") events.told(JSON.parse(data));
      else events.bytes(new Uint8Array(data));
    });
    socket.addEventListener("close", ({ reason }) => {
      events.closed(reason);
      setTimeout(open, wait_ms);
      wait_ms = Math.min(2 * wait_ms, kLongestWait_ms);
    });
  };
  open();
  return {
    send(message) {
      if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
    },
    /** For tests: as if the network had ended. */
    close: () => socket.close(),
  };
}
