"""A ROS 2 node that does as a test tells it: orders on standard input, events on standard output.

Each is one line of JSON. An order ``{"do": …, "order": number, …}`` is answered by
``{"event": "done", "order": number}`` with a ``result`` or a ``fault``. What the graph brings is
told as events: ``message``, ``request`` (of a service), ``goal`` and ``cancel`` (of an action), and
of a goal sent by this node ``answer``, ``feedback`` and ``result``; each with the ``name`` of its
topic, service or action. Runs under the test bed's Python.
"""

from __future__ import annotations

import contextlib
import json
import os
import queue
import sys
import threading
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

import rclpy
from rclpy._rclpy_pybind11 import RCLError
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.exceptions import InvalidHandle
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.task import Future

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "templates" / "ros2"))

from action_client import Client
from peer_messages import fill, load, plain, profile

PATIENCE = 60.0


class Server(ActionServer):
    """An action server, of which some results get lost: they are not among the ten that the
    middleware keeps until they have arrived."""

    losing = 0

    def _send_result_response(self, header: Any, future: Any) -> None:
        if self.losing:
            self.losing -= 1
        else:
            super()._send_result_response(header, future)


class Peer:
    def __init__(self, name: str) -> None:
        self.node = Node(name)
        self.group = ReentrantCallbackGroup()
        self.lock = threading.Lock()
        self.publishers: dict[str, Any] = {}
        self.kept: list[Any] = []
        self.links: list[tuple[str, str, float]] = []
        self.said: dict[str, Any] = {}  # messages by topic
        self.goals: dict[str, Any] = {}
        self.servers: dict[str, Any] = {}
        self.waiting: dict[str, queue.SimpleQueue[dict[str, Any]]] = {}
        self.count = 0

    def tell(self, event: str, **fields: Any) -> None:
        line = json.dumps({"event": event, **fields})
        with self.lock:
            print(line, flush=True)

    def number(self) -> str:
        with self.lock:
            self.count += 1
            return str(self.count)

    # Who is known to the middleware: what it has to say to those that it does not know yet, an answer
    # or feedback, it drops for good. The other side may know of it long before, on a busy machine.

    def until(self, look: Callable[[], Any], fault: str) -> None:
        end = time.monotonic() + PATIENCE
        while not look():
            if time.monotonic() > end:
                raise TimeoutError(fault)
            time.sleep(0.005)

    def know_client(self, name: str) -> None:
        self.until(lambda: self.node.count_clients(name), f"{name} has no client")

    def be_known(self, name: str) -> None:
        """Wait until the server of a service knows the clients that this node has made.

        Its node answers a client that was made later; and it gets to know them in their order.
        """
        wanted, found = self.node.resolve_service_name(name), []

        def look() -> bool:
            for node, space in self.node.get_node_names_and_namespaces():
                with contextlib.suppress(RuntimeError):  # it is only about to be known, or has left
                    served = dict(self.node.get_service_names_and_types_by_node(node, space))
                    if wanted in served:
                        found.append(f"{space.rstrip('/')}/{node}/get_parameters")
            return bool(found)

        self.until(look, f"no node has the service {name}")
        for asked in found:
            self.ask(asked)

    def ask(self, name: str) -> None:
        """Ask a node for none of its parameters, again and again until it answers."""
        class_ = load("rcl_interfaces/srv/GetParameters")
        client = self.node.create_client(class_, name, callback_group=self.group)
        answered = threading.Event()
        end = time.monotonic() + PATIENCE
        while True:
            client.call_async(class_.Request()).add_done_callback(lambda _: answered.set())
            if answered.wait(0.5):
                break
            if time.monotonic() > end:
                raise TimeoutError(f"{name} does not answer")
        self.node.destroy_client(client)

    def see_end(self, node: str) -> None:
        """Wait until a node that has ended is no longer known: what is sent to it meanwhile is lost."""
        self.until(lambda: node not in self.node.get_node_names(), f"{node} is still known")

    # Topics

    def subscribe(self, name: str, type: str, qos: dict[str, Any]) -> None:
        def heard(message: Any) -> None:
            self.tell("message", name=name, data=plain(message), time=time.monotonic())

        # In a group that several threads may enter, messages would overtake each other.
        alone = MutuallyExclusiveCallbackGroup()
        self.kept.append(
            self.node.create_subscription(
                load(type), name, heard, profile(**qos), callback_group=alone
            )
        )

    def publish(
        self, name: str, type: str, data: Any, matched: int, qos: dict[str, Any], rate: float = 0.0
    ) -> float:
        class_ = load(type)
        if name not in self.publishers:
            self.publishers[name] = self.node.create_publisher(class_, name, profile(**qos))
        publisher = self.publishers[name]
        end = time.monotonic() + PATIENCE
        while publisher.get_subscription_count() < matched:
            if time.monotonic() > end:
                raise TimeoutError(f"nobody listens to {name}")
            time.sleep(0.005)
        start = time.monotonic()
        for number, part in enumerate(data if isinstance(data, list) else [data]):
            publisher.publish(fill(class_(), part))
            if rate:
                time.sleep(max(0.0, start + (number + 1) / rate - time.monotonic()))
        return time.monotonic()

    def publish_bytes(self, name: str, type: str, content: list[int]) -> None:
        """Publish what need not be a message."""
        publisher = self.node.create_publisher(load(type), name, profile())
        self.kept.append(publisher)
        while not publisher.get_subscription_count():
            time.sleep(0.005)
        publisher.publish(bytes(content))

    def say(self, name: str, type: str, data: Any) -> None:
        """Publish ten times a second, until the next order for this topic."""
        first = name not in self.said
        self.said[name] = fill(load(type)(), data)
        if first:
            publisher = self.node.create_publisher(load(type), name, profile())
            self.steadily(0.1, lambda: publisher.publish(self.said[name]))

    def broadcast(self, links: list[tuple[str, str, float]]) -> None:
        """Tell links, 20 times per second, until the next order: (parent, child, x); that between
        map and dock is latched."""
        from geometry_msgs.msg import TransformStamped
        from tf2_msgs.msg import TFMessage

        def told(pairs: Any) -> Any:
            message = TFMessage()
            for parent, child, x in pairs:
                link = TransformStamped(child_frame_id=child)
                link.header.frame_id, link.transform.translation.x = parent, x
                link.header.stamp = self.node.get_clock().now().to_msg()
                message.transforms.append(link)
            return message

        first, self.links = not self.links, links
        if first:
            latched = profile(durability="transient_local")
            static = self.node.create_publisher(TFMessage, "/tf_static", latched)
            static.publish(told([("map", "dock", 5.0)]))
            moving = self.node.create_publisher(TFMessage, "/tf", profile())
            self.kept.append(static)
            self.steadily(0.05, lambda: moving.publish(told(self.links)))

    # Services

    def serve(self, name: str, type: str, reply: Any) -> None:
        class_ = load(type)

        def answer(request: Any, response: Any) -> Any:
            number = self.number()
            inbox = self.waiting[number] = queue.SimpleQueue()
            self.tell("request", name=name, id=number, data=plain(request))
            data = inbox.get()["data"] if reply is None else reply
            self.know_client(name)
            return fill(response, data)

        self.servers[name] = self.node.create_service(
            class_, name, answer, callback_group=self.group
        )

    def call(self, name: str, type: str, data: Any) -> Any:
        class_ = load(type)
        client = self.node.create_client(class_, name, callback_group=self.group)
        self.until(client.service_is_ready, f"there is no service {name}")
        self.be_known(name)
        return plain(client.call(fill(class_.Request(), data)))

    def start_call(self, name: str, type: str, data: Any) -> None:
        """Call a service; its response is told as an event."""

        def call() -> None:
            self.tell("response", name=name, data=self.call(name, type, data))

        threading.Thread(target=call, daemon=True).start()

    def flood(self, name: str, type: str, data: Any, count: int, at_once: int) -> list[Any]:
        """Call a service so often, with so many calls at once; the answers."""
        class_ = load(type)
        client = self.node.create_client(
            class_, name, callback_group=self.group, qos_profile=QoSProfile(depth=at_once)
        )
        self.until(client.service_is_ready, f"there is no service {name}")
        self.be_known(name)
        free = threading.Semaphore(at_once)
        answers: queue.SimpleQueue[Any] = queue.SimpleQueue()

        def answered(future: Any) -> None:
            free.release()
            answers.put(plain(future.result()))

        for _ in range(count):
            if not free.acquire(timeout=PATIENCE):
                raise TimeoutError("a call is not answered")
            client.call_async(fill(class_.Request(), data)).add_done_callback(answered)
        found = [answers.get(timeout=PATIENCE) for _ in range(count)]
        self.node.destroy_client(client)
        return found

    def tell_server(self, id: str, **words: Any) -> None:
        """To a service: ``data``. To an action: ``feedback``, ``end`` with a ``result``, or both."""
        self.waiting[id].put(words)

    # Actions

    def act(
        self, name: str, type: str, accept: bool | None = True, cancel: bool | None = True,
        end: str = "", lose: int = 0,
    ) -> None:  # fmt: skip
        """``accept`` goals, grant a ``cancel``, None: when told, and never; ``end`` says how each
        goal ends at once; so many results are sent, but get ``lose``d on the way."""
        class_ = load(type)
        parts = f"{name}/_action"
        ids: dict[bytes, str] = {}

        def execute(goal: Any) -> Any:
            number = self.number()
            inbox = self.waiting[number] = queue.SimpleQueue()
            uuid = goal.goal_id.uuid.tobytes().hex()
            self.tell("goal", name=name, id=number, uuid=uuid, data=plain(goal.request))
            ids[bytes(goal.goal_id.uuid)] = number
            words: dict[str, Any] = {"end": end}
            while not words.get("end"):
                words = inbox.get()
                feedback = words.get("feedback", [])
                self.until(lambda: self.node.count_subscribers(f"{parts}/feedback"), "no client")
                for part in feedback if isinstance(feedback, list) else [feedback]:
                    goal.publish_feedback(fill(class_.Feedback(), part))
            # Whoever asked for the cancel was told of it before rclpy takes note of it.
            while words["end"] == "canceled" and not goal.is_cancel_requested:
                time.sleep(0.001)
            self.know_client(f"{parts}/get_result")
            getattr(goal, words["end"])()
            return fill(class_.Result(), words.get("result", {}))

        def asked(request: Any) -> Any:
            self.know_client(f"{parts}/send_goal")
            if accept is None:
                number = self.number()
                inbox = self.waiting[number] = queue.SimpleQueue()
                self.tell("asked", name=name, id=number, data=plain(request))
                return GoalResponse.ACCEPT if inbox.get()["accept"] else GoalResponse.REJECT
            if not accept:
                self.tell("goal", name=name, id="", data=plain(request))
            return GoalResponse.ACCEPT if accept else GoalResponse.REJECT

        async def cancelled(goal: Any) -> Any:
            self.know_client(f"{parts}/cancel_goal")
            uuid = bytes(goal.goal_id.uuid)
            self.until(lambda: uuid in ids, "the goal is not carried out")
            self.tell("cancel", name=name, id=ids[uuid])
            if cancel is None:
                await Future()
            return CancelResponse.ACCEPT if cancel else CancelResponse.REJECT

        server = self.servers[name] = Server(
            self.node, class_, name, execute, goal_callback=asked, cancel_callback=cancelled,
            callback_group=self.group,
        )  # fmt: skip
        server.losing = lose

    def withdraw(self, name: str) -> None:
        """Take a service or an action off the graph."""
        self.servers.pop(name).destroy()

    def send_goal(self, name: str, type: str, data: Any) -> str:
        class_ = load(type)
        client = Client(self.node, class_, name, callback_group=self.group)
        self.kept.append(client)
        self.until(client.server_is_ready, f"there is no action {name}")
        self.be_known(f"{name}/_action/send_goal")
        number = self.number()

        def heard(message: Any) -> None:
            self.tell("feedback", name=name, id=number, data=plain(message.feedback))

        def finished(future: Any) -> None:
            done = future.result()
            self.tell("result", name=name, id=number, status=done.status, data=plain(done.result))

        def answered(future: Any) -> None:
            goal = future.result()
            self.goals[number] = client, goal
            self.tell("answer", name=name, id=number, accepted=goal.accepted)
            if goal.accepted:
                client.ask(goal.get_result_async).add_done_callback(finished)

        goal = fill(class_.Goal(), data)
        future = client.ask(lambda: client.send_goal_async(goal, feedback_callback=heard))
        future.add_done_callback(answered)
        return number

    def flood_goals(
        self, name: str, type: str, data: Any, count: int, at_once: int
    ) -> list[int | None]:
        """Send so many goals, no more at once; the status with which each ended, None: rejected."""
        class_ = load(type)
        deep = QoSProfile(depth=at_once)
        client = Client(
            self.node, class_, name, callback_group=self.group,
            goal_service_qos_profile=deep, result_service_qos_profile=deep,
        )  # fmt: skip
        self.until(client.server_is_ready, f"there is no action {name}")
        self.be_known(f"{name}/_action/send_goal")
        free = threading.Semaphore(at_once)
        ends: queue.SimpleQueue[int | None] = queue.SimpleQueue()

        def ended(status: int | None) -> None:
            free.release()
            ends.put(status)

        def answered(future: Any) -> None:
            goal = future.result()
            if goal.accepted:
                result = client.ask(goal.get_result_async)
                result.add_done_callback(lambda done: ended(done.result().status))
            else:
                ended(None)

        for _ in range(count):
            if not free.acquire(timeout=PATIENCE):
                raise TimeoutError("a goal has not ended")
            goal = fill(class_.Goal(), data)
            client.ask(lambda goal=goal: client.send_goal_async(goal)).add_done_callback(answered)
        found = [ends.get(timeout=PATIENCE) for _ in range(count)]
        client.destroy()
        return found

    def goal_ids(self) -> list[str]:
        """Of the goals sent by this node that were answered."""
        return [bytes(goal.goal_id.uuid).hex() for _, goal in self.goals.values()]

    def cancel_goal(self, id: str) -> None:
        client, goal = self.goals[id]
        client.ask(goal.cancel_goal_async)

    # The graph

    def set_parameter(self, node: str, name: str, value: Any) -> list[str]:
        from rclpy.parameter import Parameter
        from rclpy.parameter_client import AsyncParameterClient

        client = AsyncParameterClient(self.node, node)
        client.wait_for_services(PATIENCE)
        future = client.set_parameters([Parameter(name, value=value)])
        while not future.done():
            time.sleep(0.01)
        return [result.reason for result in future.result().results]

    def topics(self) -> dict[str, list[str]]:
        return dict(self.node.get_topic_names_and_types())

    def senders(self, name: str) -> list[str]:
        """The nodes that publish a topic."""
        return [end.node_name for end in self.node.get_publishers_info_by_topic(name)]

    def qos_of(self, node: str, name: str) -> list[str]:
        """Reliability and durability of a node's end of a topic, once it is known."""
        for _ in range(300):
            ends = self.node.get_publishers_info_by_topic(name)
            ends += self.node.get_subscriptions_info_by_topic(name)
            for end in ends:
                if end.node_name == node:
                    return [end.qos_profile.reliability.name, end.qos_profile.durability.name]
            time.sleep(0.05)
        raise TimeoutError(f"{node} has no end of {name}")

    def ends_of(self, prefix: str) -> dict[str, list[str]]:
        """Topics and services of the nodes whose name begins so: published, heard, served."""
        found: dict[str, list[str]] = {"publishes": [], "hears": [], "serves": []}
        for name, space in self.node.get_node_names_and_namespaces():
            if name.startswith(prefix):
                ask = self.node
                for key, names in (
                    ("publishes", ask.get_publisher_names_and_types_by_node(name, space)),
                    ("hears", ask.get_subscriber_names_and_types_by_node(name, space)),
                    ("serves", ask.get_service_names_and_types_by_node(name, space)),
                ):
                    found[key] += [topic for topic, _ in names]
        return found

    def repeat(
        self, name: str, type: str, data: Any, qos: dict[str, Any], period: float = 0.1
    ) -> None:
        """Publish ten times a second, or with this period, from now on, as sensors do."""
        self.publish(name, type, data, 0, qos)
        publisher, message = self.publishers[name], fill(load(type)(), data)
        self.steadily(period, lambda: publisher.publish(message))

    def steadily(self, period: float, act: Callable[[], None]) -> None:
        """Do something again and again. A timer of rclpy takes ten times as much processor time."""

        def go_on() -> None:
            with contextlib.suppress(InvalidHandle, RCLError):
                while rclpy.ok():
                    act()
                    time.sleep(period)

        threading.Thread(target=go_on, daemon=True).start()

    def play(
        self, name: str, type: str, data: Any, start: float, until: float, speed: float, end: float,
    ) -> None:  # fmt: skip
        """Play a bag: the clock in steps of 20 ms, and a message with every fifth for some time."""
        clock = self.node.create_publisher(load("rosgraph_msgs/msg/Clock"), "/clock", 10)
        self.publish(name, type, [], 1, {})
        for step in range(round(end / 0.02)):
            sec, part = divmod(start + step * 0.02, 1.0)
            now = {"clock": {"sec": int(sec), "nanosec": int(part * 1e9)}}
            clock.publish(fill(clock.msg_type(), now))
            if step % 5 == 0 and step * 0.02 < until - 0.001:
                self.publish(name, type, data, 1, {})
            time.sleep(0.02 / speed)

    def obey(self, line: str) -> None:
        order = json.loads(line)
        do, number = order.pop("do"), order.pop("order")
        try:
            self.tell("done", order=number, result=getattr(self, do)(**order))
        except Exception as error:
            self.tell("done", order=number, fault=f"{type(error).__name__}: {error}")


def main() -> None:
    rclpy.init()
    peer = Peer(sys.argv[1])
    executor = MultiThreadedExecutor(num_threads=8)
    executor.add_node(peer.node)

    def spin() -> None:
        while rclpy.ok():
            try:
                executor.spin()
            except ExternalShutdownException:
                return
            except Exception:  # of a server that was withdrawn with requests waiting, for one
                traceback.print_exc()

    spinning = threading.Thread(target=spin, daemon=True)
    spinning.start()
    for line in sys.stdin:
        # An order may wait for something (a subscriber, a service); others may not have to.
        threading.Thread(target=peer.obey, args=(line,), daemon=True).start()
    # Leave the graph in order; callbacks that still wait for orders are not worth waiting for.
    rclpy.try_shutdown()
    spinning.join(5.0)
    peer.node.destroy_node()
    os._exit(0)


main()
