"""A ROS node that does what its standard input tells it: the robot's side in tests.

Each line is a JSON object with ``do``; when it is done, ``{"done": n}`` is printed for the n-th.
What is heard on topics, and what servers are asked, is printed as it comes.
"""

import collections
import json
import os
import queue
import signal
import socket
import sys
import threading
import time

import actionlib
import ros_links
import rosgraph
import roslib.message
import rospy
from actionlib_msgs.msg import GoalStatus
from genpy.message import fill_message_args
from geometry_msgs.msg import TransformStamped
from rosgraph_msgs.msg import Clock

PRINTING = threading.Lock()
PATIENCE = 60.0


def tell(**document):
    with PRINTING:
        print(json.dumps(document), flush=True)


def plain(message):
    """A message as JSON."""
    if hasattr(message, "__slots__"):
        return {name: plain(getattr(message, name)) for name in message.__slots__}
    if isinstance(message, (list, tuple, bytes)):  # bytes: of uint8
        return [plain(part) for part in message]
    if isinstance(message, float) and message != message:
        return "NaN"
    return message


def filled(message, fields):
    fill_message_args(message, [fields])
    return message


def links(publisher):
    """The connections of a publisher whose other ends are there.

    rospy also counts those to subscribers that have gone, until the next one comes.
    """
    return [link for link in publisher.impl.connections if is_open(link.socket)]


def is_open(link):
    try:
        return link is not None and link.recv(1, socket.MSG_PEEK | socket.MSG_DONTWAIT) != b""
    except BlockingIOError:  # nothing comes this way, as it should be
        return True
    except OSError:
        return False


def await_links(*topics):
    """Wait until this node's connections on some topics stand, as far as it has such."""
    names = {rospy.resolve_name(topic) for topic in topics}
    ros_links.await_links(rosgraph.get_master_uri(), rospy.get_name(), names)


def type_of_goal(client):
    return type(client.ActionSpec().action_goal.goal)()


class Service:
    """Answers as its ``mode`` says: "answer", "fail", "throw", "hang", "die", or "hold", which waits
    for a ``reply``."""

    def __init__(self, name, type_):
        self.type = roslib.message.get_service_class(type_)
        self.mode, self.fields, self.delay = "answer", {}, 0.0
        self.replies = queue.SimpleQueue()
        self.name = name
        self.server = rospy.Service(name, self.type, self.serve)

    def serve(self, request):
        tell(asked=self.name, message=plain(request))
        mode, delay, fields = self.mode, self.delay, self.fields
        time.sleep(delay)
        if mode == "hold":
            fields = self.replies.get()
        if mode == "die":
            os.kill(os.getpid(), signal.SIGKILL)
        if mode == "throw":
            raise RuntimeError("thrown by the server")
        if mode == "fail":
            return None
        while mode == "hang" and not rospy.is_shutdown():
            time.sleep(0.05)
        return filled(self.type._response_class(), fields)


class Action:
    """Serves goals as its ``mode`` says when they come; "hold" keeps them until they are ended."""

    def __init__(self, name, type_):
        self.type = roslib.message.get_message_class(type_)
        self.mode, self.fields, self.feedback, self.delay = "succeed", {}, 0, 0.0
        self.name = name
        self.handles = []
        rospy.set_param("actionlib_server_pub_queue_size", 10000)  # no feedback is to be lost here
        self.server = actionlib.ActionServer(
            name, self.type, self.on_goal, self.on_cancel, auto_start=False
        )
        self.server.start()

    def on_goal(self, handle):
        self.handles.append(handle)
        mode = self.mode
        if mode == "reject":
            handle.set_rejected()
        elif mode == "recall":
            handle.set_canceled()
        elif mode != "ignore":
            handle.set_accepted()
        # Only now: who hears of the goal may want it finished at once.
        identity = handle.get_goal_id().id
        active = (GoalStatus.ACTIVE, GoalStatus.PREEMPTING)
        others = [h for h in self.handles[:-1] if h.get_goal_status().status in active]
        running = len(others)
        tell(asked=self.name, id=identity, message=plain(handle.get_goal()), running=running)
        if mode not in ("reject", "recall", "ignore"):
            threading.Thread(target=self.act, args=(handle, mode), daemon=True).start()

    def on_cancel(self, handle):
        tell(cancelled=self.name)
        if self.mode == "deaf":
            handle.set_succeeded(filled(type(self.type().action_result.result)(), self.fields))
        elif self.mode != "go on":
            handle.set_canceled()

    def act(self, handle, mode):
        numbers = range(self.feedback) if isinstance(self.feedback, int) else self.feedback
        for number in numbers:
            progress = type(self.type().action_feedback.feedback)(float(number))
            handle.publish_feedback(progress)
        time.sleep(self.delay)
        self.finish(handle, mode)

    def finish(self, handle, mode):
        if handle.get_goal_status().status not in (GoalStatus.ACTIVE, GoalStatus.PREEMPTING):
            return
        result = filled(type(self.type().action_result.result)(), self.fields)
        if mode == "succeed":
            handle.set_succeeded(result)
        elif mode == "abort":
            handle.set_aborted(result, "did not work")
        elif mode == "preempt":
            handle.set_canceled(result, "somebody else was quicker")


def connected_client(name, type_, client=None):
    """The client of an action, or a new one, once what it and the server send will arrive."""
    client = client or actionlib.ActionClient(name, type_)
    if not client.wait_for_server(rospy.Duration(PATIENCE)):
        raise RuntimeError("there is no action " + name)
    await_links(*(name + part for part in ("/goal", "/cancel", "/status", "/feedback", "/result")))
    return client


class Puppet:
    def __init__(self):
        self.publishers = {}
        self.steady = {}
        self.turns = collections.defaultdict(threading.Lock)
        self.servers = {}
        self.subscribers = []
        self.clients = {}
        self.kept = []  # goals; actionlib forgets those that nobody keeps

    def publish(self, topic, type, fields, connected=True, times=1, rate=0.0, md5=None,
                other=None):  # fmt: skip
        is_new = topic not in self.publishers
        if is_new:
            message_class = roslib.message.get_message_class(type)
            if md5 is not None:  # as from another version of the package
                message_class._md5sum = md5
            self.publishers[topic] = rospy.Publisher(topic, message_class, queue_size=10000)
        publisher = self.publishers[topic]
        end = time.monotonic() + PATIENCE
        while connected and not links(publisher):
            if time.monotonic() > end:
                raise RuntimeError("nobody subscribes to " + topic)
            time.sleep(0.005)
        if connected and is_new:
            await_links(topic)
        start = time.monotonic()
        for number in range(times):
            odd = other is not None and number % 2
            publisher.publish(filled(publisher.data_class(), other if odd else fields))
            if rate:
                time.sleep(max(0.0, start + (number + 1) / rate - time.monotonic()))

    def steadily(self, topic, type, fields):
        """Publish as a sensor does, 20 times per second, until the next order for this topic."""
        first = topic not in self.steady
        with self.turns[topic]:  # what was sent until now does not come once more after it
            self.publish(topic, type, fields)
            self.steady[topic] = type, fields
        if first:
            threading.Thread(target=self.go_on, args=(topic,), daemon=True).start()

    def broadcast(self, links):
        """Tell links as tf2 does, 20 times per second, until the next order: (parent, child, x)."""
        import tf2_ros

        def told(pair):
            link = TransformStamped()
            link.header.frame_id, link.child_frame_id, link.transform.translation.x = pair
            link.header.stamp, link.transform.rotation.w = rospy.Time.now(), 1.0
            return link

        def go_on():
            broadcaster = tf2_ros.TransformBroadcaster()
            while not rospy.is_shutdown():
                broadcaster.sendTransform([told(pair) for pair in self.links])
                time.sleep(0.05)

        first, self.links = not hasattr(self, "links"), links
        if first:
            self.kept.append(tf2_ros.StaticTransformBroadcaster())
            self.kept[-1].sendTransform(told(("map", "dock", 5.0)))
            threading.Thread(target=go_on, daemon=True).start()

    def go_on(self, topic):
        while not rospy.is_shutdown():
            time.sleep(0.05)
            with self.turns[topic]:
                self.publish(topic, *self.steady[topic], connected=False)

    def listen(self, topic, type, connected=True):
        """Listen to a topic, and to all that those send to it who are there, if they are."""
        message_class = roslib.message.get_message_class(type)
        if type == "std_msgs/String" and topic.rpartition("/")[2] in ("events", "state", "model"):
            hear = lambda m: tell(heard=topic, message=json.loads(m.data))  # noqa: E731
        else:
            hear = lambda m: tell(heard=topic, message=plain(m))  # noqa: E731
        self.subscribers.append(rospy.Subscriber(topic, message_class, hear))
        if connected:
            await_links(topic)

    def lose(self, node):
        """Wait until all was heard that a node which has ended has sent."""
        end = time.monotonic() + PATIENCE
        links = [link for one in self.subscribers for link in one.impl.connections]
        while any(link.callerid_pub == node and is_open(link.socket) for link in links):
            assert time.monotonic() < end, f"{node} goes on"
            time.sleep(0.01)

    def service(self, name, type, **settings):
        self.serve(Service, name, type, settings)

    def action(self, name, type, **settings):
        self.serve(Action, name, type, settings)

    def serve(self, make, name, type, settings):
        if name not in self.servers:
            self.servers[name] = make(name, type)
        for attribute, value in settings.items():
            setattr(self.servers[name], attribute, value)

    def reply(self, name, fields):
        self.servers[name].replies.put(fields)

    def progress(self, name, fields):
        """Give feedback of the latest goal."""
        server = self.servers[name]
        message = filled(type(server.type().action_feedback.feedback)(), fields)
        server.handles[-1].publish_feedback(message)

    def finish(self, name, mode, **settings):
        server = self.servers[name]
        vars(server).update(settings)
        server.finish(server.handles[-1], mode)

    def withdraw(self, name):
        self.servers.pop(name).server.shutdown("by the test")

    def shout(self, name, count):
        """Somebody else's goals."""
        # Of more than wait to be sent, which are ten, actionlib's client leaves out the first.
        rospy.set_param("actionlib_client_pub_queue_size", 10 + count)
        client = connected_client(name, self.servers[name].type)
        goal = type(self.servers[name].type().action_goal.goal)()
        self.foreign = [client.send_goal(goal) for _ in range(count)]

    def cancel_all(self, name):
        """Somebody else's cancel of whatever runs."""
        self.publish(name + "/cancel", "actionlib_msgs/GoalID", {})

    def call(self, name, type, fields):
        """Call a service; what comes of it is printed."""
        rospy.wait_for_service(name, PATIENCE)
        proxy = rospy.ServiceProxy(name, roslib.message.get_service_class(type))

        def work():
            try:
                tell(answered=name, message=plain(proxy(filled(proxy.request_class(), fields))))
            except rospy.ServiceException as error:
                tell(answered=name, failure=str(error))

        threading.Thread(target=work, daemon=True).start()

    def send(self, name, type, fields):
        """Send a goal; what comes of it is printed."""
        self.send_by(self.client_of(name, type), name, fields)

    def client_of(self, name, type):
        action = roslib.message.get_message_class(type)
        client = self.clients[name] = connected_client(name, action, self.clients.get(name))
        return client

    def send_by(self, client, name, fields):
        def moved(handle):
            if handle.get_comm_state() == actionlib.CommState.DONE:
                text = handle.get_goal_status_text()
                state, result = handle.get_terminal_state(), plain(handle.get_result())
                tell(ended=name, status=state, text=text, result=result)

        def heard(_, feedback):
            tell(progress=name, message=plain(feedback))

        self.sent = client.send_goal(filled(type_of_goal(client), fields), moved, heard)
        tell(sent=name, id=self.sent.comm_state_machine.action_goal.goal_id.id)

    def flood(self, name, type, fields, count):
        """Send goals, no more at once than actionlib's queue holds, when those of the last flood have
        ended; what comes of each is printed."""
        self.kept.clear()
        client = self.client_of(name, type)
        unknown = actionlib.CommState.WAITING_FOR_GOAL_ACK
        for _ in range(count):
            self.send_by(client, name, fields)
            self.kept.append(self.sent)
            while sum(goal.get_comm_state() == unknown for goal in self.kept[-16:]) > 8:
                time.sleep(0.001)

    def chain(self, name, type, count):
        """Send goals, each as soon as the result of the one before has come; their ends are printed
        together."""
        action = roslib.message.get_message_class(type)
        client = self.clients[name] = connected_client(name, action)
        done = queue.SimpleQueue()

        def moved(handle):
            if handle.get_comm_state() == actionlib.CommState.DONE:
                done.put((handle.get_terminal_state(), handle.get_goal_status_text()))

        def work():
            ends = []
            for _ in range(count):
                running = client.send_goal(type_of_goal(client), moved)  # lost unless it is kept
                ends.append(done.get())
            tell(chained=name, ends=ends, last=running.get_goal_status())

        # Not in the callback: actionlib holds locks there that another thread may wait for.
        threading.Thread(target=work, daemon=True).start()

    def cancel(self):
        """Cancel the goal that was sent last."""
        self.sent.cancel()

    def clock(self, seconds, to):
        self.clock_for(to).publish(Clock(rospy.Time.from_sec(seconds)))

    def clock_for(self, to):
        """The publisher of the clock, once a node listens to it.

        Every node of a simulated system does, whoever comes first.
        """
        if "/clock" not in self.publishers:
            self.publishers["/clock"] = rospy.Publisher("/clock", Clock, queue_size=100)
        publisher = self.publishers["/clock"]
        while not any(link.endpoint_id == to for link in links(publisher)):
            time.sleep(0.005)
        return publisher

    def play(self, topic, type, fields, to, start, seconds, speed, end):
        """Play a bag: the clock in steps of 20 ms, and a message with every fifth for some time."""
        clock = self.clock_for(to)
        self.publish(topic, type, fields, times=0)
        for step in range(round(end / 0.02)):
            clock.publish(Clock(rospy.Time.from_sec(start + step * 0.02)))
            if step % 5 == 0 and step * 0.02 < seconds - 0.001:
                self.publish(topic, type, fields)
            time.sleep(0.02 / speed)  # never faster, even after it was held up


def main():
    rospy.init_node("puppet", anonymous=True, disable_signals=True)
    puppet = Puppet()
    for number, line in enumerate(sys.stdin):
        order = json.loads(line)
        try:
            getattr(puppet, order.pop("do"))(**order)
            tell(done=number)
        except Exception as error:
            tell(done=number, failed=f"{type(error).__name__}: {error}")
    rospy.signal_shutdown("end of input")


if __name__ == "__main__":
    main()
