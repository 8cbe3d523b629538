"""Descriptions of robots as students write them."""
import math

BURGER = '''<robot name="small">
  <link name="base_footprint"/>
  <joint name="base_joint" type="fixed">
    <parent link="base_footprint"/><child link="base_link"/><origin xyz="0 0 0.01"/>
  </joint>
  <link name="base_link">
    <collision><origin xyz="-0.03 0 0.07"/><geometry><box size="0.14 0.14 0.14"/></geometry></collision>
    <visual><geometry><box size="0.14 0.14 0.14"/></geometry></visual>
  </link>
  <joint name="left_joint" type="continuous">
    <parent link="base_link"/><child link="left_wheel"/><origin xyz="0 0.08 0.023" rpy="-1.5707963 0 0"/>
    <axis xyz="0 0 1"/>
  </joint>
  <link name="left_wheel">
    <collision><geometry><cylinder length="0.018" radius="0.033"/></geometry></collision>
  </link>
  <joint name="right_joint" type="continuous">
    <parent link="base_link"/><child link="right_wheel"/><origin xyz="0 -0.08 0.023" rpy="-1.5707963 0 0"/>
  </joint>
  <link name="right_wheel">
    <collision><geometry><cylinder length="0.018" radius="0.033"/></geometry></collision>
  </link>
  <joint name="scan_joint" type="fixed">
    <parent link="base_link"/><child link="base_scan"/><origin xyz="-0.03 0 0.17" rpy="0 0 3.14159265"/>
  </joint>
  <link name="base_scan"/>
  <gazebo reference="base_link"><material>Gazebo/Red</material></gazebo>
  <gazebo>
    <plugin name="drive" filename="libgazebo_ros_diff_drive.so">
      <leftJoint>left_joint</leftJoint><rightJoint>right_joint</rightJoint>
      <wheelSeparation>0.16</wheelSeparation><wheelDiameter>0.066</wheelDiameter>
      <odometryFrame>odom</odometryFrame><robotBaseFrame>base_footprint</robotBaseFrame>
      <publishWheelJointState>true</publishWheelJointState><updateRate>50</updateRate>
    </plugin>
  </gazebo>
  <gazebo reference="base_scan">
    <sensor type="ray" name="lidar">
      <update_rate>10</update_rate>
      <ray>
        <scan><horizontal><samples>4</samples><min_angle>0</min_angle><max_angle>4.71238898</max_angle></horizontal></scan>
        <range><min>0.1</min><max>3.5</max></range>
      </ray>
      <plugin name="scanner" filename="libgazebo_ros_laser.so">
        <topicName>scan</topicName><frameName>base_scan</frameName>
      </plugin>
    </sensor>
  </gazebo>
</robot>
'''
CAMERA = '''<gazebo reference="base_scan">
  <sensor type="camera" name="eye"><update_rate>20</update_rate>
    <camera><horizontal_fov>1.5707963</horizontal_fov><image><width>64</width><height>48</height></image></camera>
    <plugin name="camera_controller" filename="libgazebo_ros_camera.so">
      <cameraName>front</cameraName><imageTopicName>image_raw</imageTopicName><frameName>eye_link</frameName>
    </plugin>
  </sensor>
</gazebo>'''
OMNI = '''<sdf version="1.6"><model name="omni">
  <link name="base"><collision name="body"><pose>0 0 0.1 0 0 0</pose>
    <geometry><cylinder><radius>0.2</radius><length>0.2</length></cylinder></geometry></collision></link>
  <plugin name="move" filename="libgazebo_ros_planar_move.so"><odometryRate>20</odometryRate></plugin>
</model></sdf>'''
BOX = '''<sdf version="1.6"><model name="box"><link name="link">
  <collision name="body"><geometry><box><size>0.4 0.2 0.6</size></box></geometry></collision>
</link></model></sdf>'''
QUARTER = math.pi / 2.0


def with_extension(urdf, extension):
    """Return a URDF with more elements in it."""
    return urdf.replace('</robot>', f'{extension}</robot>')
